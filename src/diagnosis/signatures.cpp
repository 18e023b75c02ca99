#include "diagnosis/signatures.hpp"

#include <algorithm>

namespace battery_sof {

double Signatures::freeShare(Eigen::Index column) const {
  return length[column] > 0.0 ? columns.col(column).norm() / length[column] : 0.0;
}

Signatures signaturesOf(const WhitenedFit& fit, const InputSequence& inputs,
                        Eigen::MatrixXd columns) {
  const Whitening whitening(fit.noise, inputs.samples);
  Signatures signatures;
  signatures.columns = std::move(columns);
  for (Eigen::Index k = 0; k < signatures.columns.cols(); ++k)
    signatures.columns.col(k) = whitening.whitened(signatures.columns.col(k));
  signatures.length = signatures.columns.colwise().norm();
  signatures.biased = fit.biased.transpose() * signatures.columns;
  signatures.columns.noalias() -= fit.biased * signatures.biased;
  return signatures;
}

double innovationVariance(const WhitenedFit& fit) {
  return std::max(1.0, fit.innovation.squaredNorm() /
                           static_cast<double>(std::max<std::size_t>(1, fit.measured)));
}

}  // namespace battery_sof
