#include "battery_sof/diagnose/residual_force.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "battery_sof/diagnose/random_bits.hpp"
#include "battery_sof/diagnose/signatures.hpp"
#include "battery_sof/predict/query.hpp"

namespace battery_sof {
namespace {

constexpr std::array<double, 9> kTimes{0.05, 0.2, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0};  // [s], PHYSICS 2.4
constexpr double kBend = 5.0;          // [A], of asinh
constexpr double kLeastShare = 1e-3;   // of a column's length that the parameters must leave
constexpr double kLeastNew = 1e-4;     // of a unit column's square that the others must leave
constexpr Eigen::Index kBlocks = 20;
constexpr int kSubsamples = 50, kStable = 40;  // PHYSICS 2.4: 50 half-block subsamples, keep 80 %
constexpr std::size_t kMostTerms = 3;
constexpr double kTermSquare = 16.0;   // z^2: the largest of 60 by chance stays below it in 99.6 % of cases
constexpr double kAlike = 0.9;
constexpr double kEnough = 0.8;        // of what the library explains
constexpr double kSecondsPerHour = 3600.0;

double forceOf(Force force, double i) {
  switch (force) {
    case Force::kCharging: return std::max(i, 0.0);
    case Force::kCompressed: return std::asinh(i / kBend);
    case Force::kQuadratic: return i * std::abs(i);
    case Force::kMagnitude:
    case Force::kCurrentMagnitude: return std::abs(i);
    default: return i;
  }
}

bool hasMemory(Force force) {
  return force != Force::kCharge && force != Force::kTime && force != Force::kDoubleLayer;
}

void fillMemory(const Drive& drive, const ForceTerm& term, Eigen::Ref<Eigen::VectorXd> column) {
  double memory = 0.0;
  for (Eigen::Index n = 0; n < column.size(); ++n) {
    const DriveStep& step = drive.samples[static_cast<std::size_t>(n)].step;
    if (term.time > 0.0)
      memory += (forceOf(term.force, step.held) - memory) * -std::expm1(-step.duration / term.time);
    else
      memory = forceOf(term.force, step.current);
    column[n] = term.force == Force::kCurrentMagnitude ? memory * step.current : memory;
  }
}

void fillState(const WhitenedFit& fit, const Drive& drive, Force force, Eigen::Ref<Eigen::VectorXd> column) {
  Simulation simulation(fit.model, {fit.point.parameters, fit.point.state, drive.first_time, drive.first_time});
  double charge = 0.0;
  for (Eigen::Index n = 0; n < column.size(); ++n) {
    const DriveStep& step = drive.samples[static_cast<std::size_t>(n)].step;
    charge += step.held * step.duration;
    if (force == Force::kDoubleLayer) simulation.advance(step);
    column[n] = force == Force::kCharge ? charge / kSecondsPerHour
                : force == Force::kTime ? step.time - drive.first_time
                                        : simulation.state()[0];
  }
}

/// The library as the innovation sees it; everything else is asked of its inner products.
struct Library {
  std::vector<ForceTerm> terms;   // those that the parameters leave something of
  Eigen::MatrixXd raw;            // samples x terms, in the terms' units
  Signatures signatures;          // of raw
  Eigen::VectorXd scale;          // length of the signatures: unit columns are raw / scale
  std::vector<Eigen::MatrixXd> block_products;  // of unit columns
  std::vector<Eigen::VectorXd> block_targets;   // with the innovation
  Eigen::MatrixXd products;
  Eigen::VectorXd target;
  double variance = 1.0;          // of the innovation
};

Library libraryOf(const WhitenedFit& fit, const Drive& drive) {
  Library library;
  const std::vector<ForceTerm> all = forceLibrary(drive);
  Eigen::MatrixXd columns = forceColumns(fit, drive, all);
  const Signatures signatures = signaturesOf(fit, drive, columns);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < columns.cols(); ++k)
    if (signatures.freeShare(k) > kLeastShare) kept.push_back(k);
  for (const Eigen::Index k : kept) library.terms.push_back(all[static_cast<std::size_t>(k)]);
  const auto count = static_cast<Eigen::Index>(kept.size());
  library.raw = columns(Eigen::all, kept);
  library.signatures = {signatures.columns(Eigen::all, kept), signatures.absorbed(Eigen::all, kept),
                        signatures.length(kept)};
  library.scale = library.signatures.columns.colwise().norm();
  library.signatures.columns *= library.scale.cwiseInverse().asDiagonal();
  library.products = Eigen::MatrixXd::Zero(count, count);
  library.target = Eigen::VectorXd::Zero(count);
  const Eigen::Index rows = columns.rows();
  for (Eigen::Index block = 0; block < kBlocks; ++block) {
    const Eigen::Index first = rows * block / kBlocks, size = rows * (block + 1) / kBlocks - first;
    const auto part = library.signatures.columns.middleRows(first, size);
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(count, count);
    products.selfadjointView<Eigen::Lower>().rankUpdate(part.transpose());
    products.triangularView<Eigen::StrictlyUpper>() = products.transpose();
    library.block_targets.push_back(part.transpose() * fit.innovation.segment(first, size));
    library.products += products;
    library.target += library.block_targets.back();
    library.block_products.push_back(std::move(products));
  }
  library.variance = innovationVariance(fit);
  return library;
}

/// A Cholesky decomposition that takes in column after column, with what is left of the others.
class Pursuit {
 public:
  Pursuit(const Eigen::MatrixXd& products, const Eigen::VectorXd& target)
      : left_(products), correlation_(target), size_(products.diagonal()) {}

  /// What taking in column k would explain of |v|^2.
  double gain(Eigen::Index k) const {
    return left_(k, k) > kLeastNew * size_[k] ? correlation_[k] * correlation_[k] / left_(k, k) : 0.0;
  }
  /// Share of a column that those taken in leave.
  double novelty(Eigen::Index k) const { return size_[k] > 0.0 ? left_(k, k) / size_[k] : 0.0; }

  void take(Eigen::Index k) {
    const Eigen::VectorXd column = left_.col(k);
    const double own = column[k];
    explained_ += correlation_[k] * correlation_[k] / own;
    correlation_ -= column * (correlation_[k] / own);
    left_.noalias() -= column * (column / own).transpose();
    left_.col(k).setZero();
    left_.row(k).setZero();
    correlation_[k] = 0.0;
  }

  double explained() const { return explained_; }

 private:
  Eigen::MatrixXd left_;
  Eigen::VectorXd correlation_, size_;
  double explained_ = 0.0;
};

template <typename Measure>
Eigen::Index largest(Eigen::Index count, Measure&& measure) {
  Eigen::Index best = -1;
  double most = 0.0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double value = measure(k);
    if (value <= most) continue;
    most = value;
    best = k;
  }
  return best;
}

/// What the whole library explains of |v|^2 / s^2, and how many independent columns it has.
struct Explained {
  double square = 0.0;
  int rank = 0;
  double z() const { return rank > 0 ? (square - rank) / std::sqrt(2.0 * rank) : 0.0; }
};

Explained explainedBy(const Library& library) {
  Pursuit pursuit(library.products, library.target);
  Explained explained;
  while (true) {
    // Pivots by what is new in a column, not by what it explains: the rank must not look at the innovation.
    const Eigen::Index next =
        largest(library.target.size(), [&](Eigen::Index k) { return pursuit.novelty(k); });
    if (next < 0 || pursuit.novelty(next) <= kLeastNew) break;
    pursuit.take(next);
    ++explained.rank;
  }
  explained.square = pursuit.explained() / library.variance;
  return explained;
}

std::vector<Eigen::Index> pursue(const Eigen::MatrixXd& products, const Eigen::VectorXd& target,
                                 double least_gain) {
  Pursuit pursuit(products, target);
  std::vector<Eigen::Index> chosen;
  while (chosen.size() < kMostTerms) {
    const Eigen::Index next = largest(target.size(), [&](Eigen::Index k) { return pursuit.gain(k); });
    if (next < 0 || pursuit.gain(next) < least_gain) break;
    pursuit.take(next);
    chosen.push_back(next);
  }
  return chosen;
}

/// Which of the chosen terms halves of the blocks choose again.
std::vector<Eigen::Index> stableTerms(const Library& library, const std::vector<Eigen::Index>& chosen) {
  std::vector<int> found(chosen.size(), 0);
  RandomBits random(1);
  for (int draw = 0; draw < kSubsamples; ++draw) {
    std::array<std::size_t, kBlocks> order;
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    for (std::size_t k = order.size() - 1; k > 0; --k) std::swap(order[k], order[random.below(k + 1)]);
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(library.products.rows(), library.products.cols());
    Eigen::VectorXd target = Eigen::VectorXd::Zero(library.target.size());
    for (std::size_t k = 0; k < order.size() / 2; ++k) {
      products += library.block_products[order[k]];
      target += library.block_targets[order[k]];
    }
    const std::vector<Eigen::Index> again = pursue(products, target, 0.0);
    for (std::size_t k = 0; k < chosen.size(); ++k)
      found[k] += std::any_of(again.begin(), again.end(), [&](Eigen::Index other) {
        return std::abs(library.products(chosen[k], other)) > kAlike;
      });
  }
  std::vector<Eigen::Index> stable;
  for (std::size_t k = 0; k < chosen.size(); ++k)
    if (found[k] >= kStable) stable.push_back(chosen[k]);
  return stable;
}

/// Weights of columns by ridge, its strength by the evidence: w ~ N(0, s^2 / lambda), the lambda that makes the data most
/// likely (MacKay 1992).
Eigen::VectorXd ridge(const Eigen::MatrixXd& products, const Eigen::VectorXd& target, double variance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(products);
  const Eigen::ArrayXd values = eigen.eigenvalues().array().max(0.0);
  const Eigen::ArrayXd along = (eigen.eigenvectors().transpose() * target).array();
  const double top = values.maxCoeff();
  double best = -HUGE_VAL, strength = top;
  for (int k = -40; k <= 20; ++k) {  // four steps a decade
    const double lambda = top * std::pow(10.0, 0.25 * k);
    const double evidence =
        (along.square() / (values + lambda) / variance - (values / lambda).log1p()).sum();
    if (evidence <= best) continue;
    best = evidence;
    strength = lambda;
  }
  return eigen.eigenvectors() * (along / (values + strength)).matrix();
}

/// Row of a term in the library; -1 when the parameters left nothing of it.
Eigen::Index rowOf(const Library& library, Force force, double time) {
  for (std::size_t k = 0; k < library.terms.size(); ++k)
    if (library.terms[k].force == force && library.terms[k].time == time) return static_cast<Eigen::Index>(k);
  return -1;
}

/// LP[max(i, 0)] is a column of the library; LP[min(i, 0)] is LP[i] less it.
void addSpectra(const Library& library, ResidualForce& force) {
  std::vector<double> times;
  for (const double time : kTimes)
    if (rowOf(library, Force::kCurrent, time) >= 0 && rowOf(library, Force::kCharging, time) >= 0)
      times.push_back(time);
  const auto count = static_cast<Eigen::Index>(times.size());
  if (count == 0) return;
  Eigen::MatrixXd mix = Eigen::MatrixXd::Zero(library.target.size(), 2 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index charging = rowOf(library, Force::kCharging, times[static_cast<std::size_t>(k)]);
    const Eigen::Index both = rowOf(library, Force::kCurrent, times[static_cast<std::size_t>(k)]);
    mix(charging, k) = library.scale[charging];
    mix(both, count + k) = library.scale[both];
    mix(charging, count + k) = -library.scale[charging];
  }
  const Eigen::VectorXd weights = ridge(mix.transpose() * library.products * mix,
                                        mix.transpose() * library.target, library.variance);
  for (Eigen::Index k = 0; k < count; ++k) {
    force.charge.push_back({times[static_cast<std::size_t>(k)], weights[k]});
    force.discharge.push_back({times[static_cast<std::size_t>(k)], weights[count + k]});
  }
}

/// RMS of what weights of the raw columns explain once the parameters took their share [V].
double explainedRms(const WhitenedFit& fit, const Drive& drive, const Library& library,
                    const Eigen::VectorXd& weights) {
  const Eigen::MatrixXd own = signaturesOf(fit, drive, fit.jacobian).absorbed;
  const Eigen::VectorXd taken =
      own.completeOrthogonalDecomposition().solve(library.signatures.absorbed * weights);
  return rmsOver(library.raw * weights - fit.jacobian * taken, drive);
}

std::string amountOf(Force force, double weight) {
  switch (force) {
    case Force::kCurrent: return sentence("%+.2f mOhm on the current", 1e3 * weight);
    case Force::kCharging: return sentence("%+.2f mOhm on charging current", 1e3 * weight);
    case Force::kCompressed: return sentence("%+.2f mV on asinh(i / 5 A)", 1e3 * weight);
    case Force::kQuadratic: return sentence("%+.3g uOhm/A on i |i|", 1e6 * weight);
    case Force::kMagnitude: return sentence("%+.2f mOhm on the current's magnitude", 1e3 * weight);
    case Force::kCurrentMagnitude:
      return sentence("%+.3g uOhm/A on the current times its magnitude", 1e6 * weight);
    case Force::kCharge: return sentence("%+.2f mV/Ah on the charge moved", 1e3 * weight);
    case Force::kTime: return sentence("%+.2f mV/min on the time", 60e3 * weight);
    case Force::kDoubleLayer: return sentence("%+.3g on the double layer's voltage", weight);
  }
  return "";
}

std::string inWords(const ForceTerm& term, double weight, double rms) {
  std::string text = amountOf(term.force, weight);
  if (term.time > 0.0)
    text += sentence(", remembered %g s", term.time);
  else if (hasMemory(term.force))
    text = "an instantaneous " + text;
  return text + sentence(" (%.2f mV)", 1e3 * rms);
}

void addTerms(const WhitenedFit& fit, const Drive& drive, const Library& library, const Explained& all,
              ResidualForce& force) {
  const std::vector<Eigen::Index> stable =
      stableTerms(library, pursue(library.products, library.target, kTermSquare * library.variance));
  if (stable.empty()) return;
  const Eigen::VectorXd target = library.target(stable);
  const Eigen::VectorXd weights = library.products(stable, stable).ldlt().solve(target);
  if (weights.dot(target) / library.variance < kEnough * (all.square - all.rank)) return;
  for (std::size_t k = 0; k < stable.size(); ++k) {
    Eigen::VectorXd alone = Eigen::VectorXd::Zero(library.target.size());
    alone[stable[k]] = weights[static_cast<Eigen::Index>(k)] / library.scale[stable[k]];
    force.terms.push_back(inWords(library.terms[static_cast<std::size_t>(stable[k])], alone[stable[k]],
                                  explainedRms(fit, drive, library, alone)));
  }
}

const MemoryWeight* strongest(const std::vector<MemoryWeight>& spectrum) {
  const auto most = std::max_element(spectrum.begin(), spectrum.end(), [](const auto& a, const auto& b) {
    return std::abs(a.weight) < std::abs(b.weight);
  });
  return most == spectrum.end() ? nullptr : &*most;
}

std::string described(const ResidualForce& force) {
  const std::string share = sentence("%.2f mV RMS (z_O = %.1f)", 1e3 * force.rms, force.omnibus_z);
  if (!force.terms.empty()) {
    std::string text = "The residual holds " + force.terms.front();
    for (std::size_t k = 1; k < force.terms.size(); ++k) text += "; " + force.terms[k];
    return text + "; currents and their memory explain " + share + " in all.";
  }
  const MemoryWeight *charge = strongest(force.charge), *discharge = strongest(force.discharge);
  std::string text = "Currents and their memory explain " + share + " of the residual, in no three stable terms";
  if (charge != nullptr && discharge != nullptr)
    text += sentence("; charging weighs most at %g s (%+.2f mOhm), discharging at %g s (%+.2f mOhm)", charge->time,
                     1e3 * charge->weight, discharge->time, 1e3 * discharge->weight);
  return text + ".";
}

}  // namespace

std::vector<ForceTerm> forceLibrary(const Drive& drive) {
  std::vector<ForceTerm> library{{Force::kCompressed}, {Force::kQuadratic},
                                 {Force::kCharge}, {Force::kTime}, {Force::kDoubleLayer}};
  if (drive.samples.empty()) return library;
  const double span = drive.samples.back().step.time - drive.samples.front().step.time;
  for (const double time : kTimes) {
    if (time > span / 3.0) break;
    for (const Force force : {Force::kCurrent, Force::kCharging, Force::kCompressed, Force::kQuadratic,
                              Force::kMagnitude, Force::kCurrentMagnitude})
      library.push_back({force, time});
  }
  return library;
}

Eigen::MatrixXd forceColumns(const WhitenedFit& fit, const Drive& drive,
                             const std::vector<ForceTerm>& library) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(drive.samples.size()), static_cast<Eigen::Index>(library.size()));
  for (std::size_t k = 0; k < library.size(); ++k) {
    auto column = columns.col(static_cast<Eigen::Index>(k));
    if (hasMemory(library[k].force))
      fillMemory(drive, library[k], column);
    else
      fillState(fit, drive, library[k].force, column);
  }
  return columns;
}

double omnibusZ(const WhitenedFit& fit, const Drive& drive) {
  return explainedBy(libraryOf(fit, drive)).z();
}

ResidualForce describeResidual(const WhitenedFit& fit, const Drive& drive) {
  const Library library = libraryOf(fit, drive);
  const Explained all = explainedBy(library);
  ResidualForce force;
  force.omnibus_z = all.z();
  if (all.rank == 0) {
    force.description = "The parameters absorb everything that currents and their memory could explain.";
    return force;
  }
  const Eigen::VectorXd unit = ridge(library.products, library.target, library.variance);
  force.rms = explainedRms(fit, drive, library, unit.cwiseQuotient(library.scale));
  addSpectra(library, force);
  addTerms(fit, drive, library, all, force);
  force.description = described(force);
  return force;
}

}  // namespace battery_sof
