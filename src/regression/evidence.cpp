#include "regression/evidence.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <unsupported/Eigen/FFT>
#include <utility>

#include "util/eigen_decomposition.hpp"

namespace battery_sof {
namespace {

constexpr double kMinStrength = 1e-6;  // [V], off
constexpr double kMaxSparse = 0.05;    // [V], of a column of a sparse fit
constexpr double kMinNoise = 3e-5;     // [V]
constexpr double kTwoPi = 6.283185307179586;
constexpr int kRounds = 60, kFewRounds = 20;
constexpr double kSettled = 0.003;      // of ln p between rounds
constexpr double kSettledNoise = 1e-4;  // of the noise between rounds

/// Sums of the columns in use, scaled by the effective sample fraction.
struct Part {
  std::vector<Eigen::Index> columns;
  Eigen::MatrixXd products;
  Eigen::VectorXd targets;
  double square, rows;
};

Part partOf(const LinearProblem& problem, double effective_sample_fraction,
            const std::vector<char>& active) {
  Part part;
  for (Eigen::Index k = 0; k < problem.products.cols(); ++k)
    if (k < problem.known() || active[problem.groupOf(k)]) part.columns.push_back(k);
  part.products = effective_sample_fraction * problem.products(part.columns, part.columns);
  part.targets = effective_sample_fraction * problem.targets(part.columns);
  part.square = effective_sample_fraction * problem.square;
  part.rows = effective_sample_fraction * problem.rows;
  return part;
}

/// ln p and all that its maximisation needs at given strengths.
struct Point {
  double evidence;
  Eigen::VectorXd mean;       // z of the columns in use
  Eigen::MatrixXd root;       // L^-1 of B = L L', lower
  Eigen::VectorXd deviation;  // D
};

/// Inverse of a lower triangle, by halves: a third of the work of solving for the unit matrix.
Eigen::MatrixXd inverseOfLower(const Eigen::Ref<const Eigen::MatrixXd>& lower) {
  const Eigen::Index n = lower.rows(), half = n / 2, rest = n - half;
  if (n <= 24) return lower.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(n, n));
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(n, n);
  inverse.topLeftCorner(half, half) = inverseOfLower(lower.topLeftCorner(half, half));
  inverse.bottomRightCorner(rest, rest) = inverseOfLower(lower.bottomRightCorner(rest, rest));
  const Eigen::MatrixXd between = -lower.bottomLeftCorner(rest, half) *
                                  inverse.topLeftCorner(half, half).triangularView<Eigen::Lower>();
  inverse.bottomLeftCorner(rest, half) =
      inverse.bottomRightCorner(rest, rest).triangularView<Eigen::Lower>() * between;
  return inverse;
}

Eigen::LLT<Eigen::MatrixXd> factored(Eigen::MatrixXd matrix) {
  Eigen::LLT<Eigen::MatrixXd> llt(matrix);
  const Eigen::VectorXd diagonal = matrix.diagonal();
  for (double jitter = 1e-13; llt.info() != Eigen::Success && jitter < 1.0; jitter *= 10.0) {
    matrix.diagonal() = diagonal * (1.0 + jitter);
    llt.compute(matrix);
  }
  return llt;
}

Point evaluated(const Part& part, const Eigen::VectorXd& deviation, double noise) {
  const double precision = 1.0 / (noise * noise);
  Eigen::MatrixXd B = precision * (deviation.asDiagonal() * part.products * deviation.asDiagonal());
  B.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> llt = factored(std::move(B));
  const Eigen::VectorXd h = precision * deviation.cwiseProduct(part.targets);
  const Eigen::VectorXd m = llt.solve(h);
  Point point;
  point.evidence = -0.5 * part.rows * std::log(kTwoPi * noise * noise) -
                   0.5 * part.square * precision + 0.5 * h.dot(m) -
                   llt.matrixLLT().diagonal().array().log().sum();
  point.mean = deviation.cwiseProduct(m);
  point.root = inverseOfLower(llt.matrixLLT());
  point.deviation = deviation;
  return point;
}

class GroupSearch {
 public:
  GroupSearch(const LinearProblem& problem, double effective_sample_fraction,
              const std::vector<char>& active)
      : problem_(problem),
        part_(partOf(problem, effective_sample_fraction, active)),
        active_(active) {}
  /// Of all groups.
  GroupSearch(const LinearProblem& problem, double effective_sample_fraction)
      : GroupSearch(problem, effective_sample_fraction, std::vector<char>(problem.groups, 1)) {}

  /// @return covariance of z where a fit ended.
  Eigen::MatrixXd covarianceOf(const LinearFit& fit) const {
    const Point point = at(fit.strength, fit.noise);
    const Eigen::MatrixXd root = point.root * point.deviation.asDiagonal();
    return root.transpose() * root;
  }

  LinearFit run(std::vector<double> strength, double noise, int rounds) const {
    for (std::size_t g = 0; g < strength.size(); ++g)
      strength[g] = std::min(strength[g], mostOf(g));
    double before = -1e300;
    Point point = at(strength, noise);
    for (int round = 0; round < rounds; ++round) {
      improve(point, strength, noise);
      point = at(strength, noise);
      const double now = point.evidence + logPrior(strength);
      if (std::abs(now - before) < kSettled) break;
      before = now;
    }
    LinearFit fit;
    fit.z = Eigen::VectorXd::Zero(problem_.products.cols());
    fit.z(part_.columns) = point.mean;
    for (std::size_t g = 0; g < strength.size(); ++g)
      if (!active_[g]) strength[g] = 0.0;
    fit.strength = std::move(strength);
    fit.noise = noise;
    fit.evidence = point.evidence + logPrior(fit.strength);
    return fit;
  }

 private:
  double logPrior(const std::vector<double>& strength) const {
    double sum = 0.0;
    for (std::size_t g = 0; g < strength.size(); ++g)
      if (active_[g]) sum -= 0.5 * std::log1p(std::pow(strength[g] / GroupPrior::kScale, 2));
    return sum;
  }

  Point at(const std::vector<double>& strength, double noise) const {
    Eigen::VectorXd deviation(part_.columns.size());
    for (Eigen::Index j = 0; j < deviation.size(); ++j) {
      const Eigen::Index k = part_.columns[j];
      deviation[j] = k < problem_.known() ? problem_.known_std[k] : strength[problem_.groupOf(k)];
    }
    return evaluated(part_, deviation, noise);
  }

  /// MacKay's fixed point: what the data fixed of a group is its own measure of how strong it is.
  void improve(const Point& point, std::vector<double>& strength, double& noise) const {
    std::vector<double> square(strength.size(), 0.0), fixed(strength.size(), 0.0);
    double all_fixed = 0.0;
    const Eigen::VectorXd inverse = point.root.colwise().squaredNorm();  // diagonal of B^-1
    for (Eigen::Index j = 0; j < point.mean.size(); ++j) {
      const double well = 1.0 - inverse[j];
      all_fixed += well;
      const Eigen::Index k = part_.columns[j];
      if (k < problem_.known()) continue;
      const std::size_t g = problem_.groupOf(k);
      square[g] += point.mean[j] * point.mean[j];
      fixed[g] += well;
    }
    for (std::size_t g = 0; g < strength.size(); ++g) {
      if (!active_[g]) continue;
      const double ratio = std::pow(strength[g] / GroupPrior::kScale, 2);
      const double next = std::sqrt(square[g] / std::max(fixed[g] + ratio / (1.0 + ratio), 1e-12));
      strength[g] = std::clamp(next, kMinStrength, mostOf(g));
    }
    const double rss = part_.square - 2.0 * part_.targets.dot(point.mean) +
                       point.mean.dot(part_.products * point.mean);
    noise = std::max(kMinNoise, std::sqrt(std::max(rss, 0.0) /
                                          std::max(part_.rows - all_fixed, 0.1 * part_.rows)));
  }

  double mostOf(std::size_t g) const {
    return problem_.most.empty() ? GroupPrior::kMost : problem_.most[g];
  }

  const LinearProblem& problem_;
  Part part_;
  std::vector<char> active_;
};

double firstNoise(const LinearProblem& problem) {
  return std::max(kMinNoise, std::sqrt(0.3 * problem.square / std::max(problem.rows, 1.0)));
}

const LinearFit& better(const LinearFit& one, const LinearFit& other) {
  return other.evidence > one.evidence ? other : one;
}

/// A fit as it is; without evidence where columns, as derivatives of a model that breaks away, are
/// so large that their products cancel or are no numbers: no fit is likelier than one without
/// errors at the least noise.
LinearFit sound(const LinearProblem& problem, double effective_sample_fraction, LinearFit fit) {
  const double most =
      -0.5 * effective_sample_fraction * problem.rows * std::log(kTwoPi * kMinNoise * kMinNoise);
  if (fit.evidence <= most && fit.z.allFinite() && std::isfinite(fit.noise)) return fit;
  return {Eigen::VectorXd::Zero(problem.products.cols()), std::vector<double>(problem.groups, 0.0),
          std::sqrt(problem.square / std::max(problem.rows, 1.0)),
          -std::numeric_limits<double>::infinity()};
}

/// Groups taken in one after the other while ln p gains more than 1.
LinearFit greedy(const LinearProblem& problem, double effective_sample_fraction) {
  std::vector<char> active(problem.groups, 0);
  std::vector<double> strength(active.size(), 0.03);
  LinearFit best = GroupSearch(problem, effective_sample_fraction, active)
                       .run(strength, firstNoise(problem), kRounds);
  while (true) {
    LinearFit next = best;
    std::size_t taken = active.size();
    for (std::size_t g = 0; g < active.size(); ++g) {
      if (active[g]) continue;
      std::vector<char> with = active;
      with[g] = 1;
      std::vector<double> from = best.strength;
      from[g] = 0.03;
      const LinearFit fit =
          GroupSearch(problem, effective_sample_fraction, with).run(from, best.noise, kFewRounds);
      if (fit.evidence <= next.evidence) continue;
      next = fit;
      taken = g;
    }
    if (taken == active.size() || next.evidence < best.evidence + 1.0) return best;
    active[taken] = 1;
    best = next;
  }
}

/// Sparse fit: sums with the columns chosen so far.
class SparseSearch {
 public:
  SparseSearch(const LinearProblem& problem, double effective_sample_fraction)
      : problem_(problem), effective_sample_fraction_(effective_sample_fraction) {}

  SparseFit run(int max_columns) {
    noise_ = firstNoise(problem_);
    for (int step = 0; step < 4 * max_columns; ++step) {
      settle();
      const Gains gains = gainsOf();
      if (update(gains)) continue;
      if (gains.best < 0 || static_cast<int>(columns_.size()) >= max_columns) break;
      columns_.push_back(gains.best);
      strength_.push_back(gains.strength);
      path_.push_back({gains.best, gains.gain});
    }
    settle();
    return result();
  }

 private:
  struct Gains {
    int best = -1;
    double gain = 0.0, strength = 0.0;
    Eigen::VectorXd own;  // strength^2 that each chosen column needs
  };

  void settle() {
    index_.resize(problem_.known());
    std::iota(index_.begin(), index_.end(), Eigen::Index{0});
    for (const int column : columns_) index_.push_back(problem_.known() + column);
    const Eigen::MatrixXd products = effective_sample_fraction_ * problem_.products(index_, index_);
    const Eigen::VectorXd targets = effective_sample_fraction_ * problem_.targets(index_);
    for (int round = 0; round < 2; ++round) {
      solve(products, targets);
      const double rss = effective_sample_fraction_ * problem_.square - 2.0 * targets.dot(mean_) +
                         mean_.dot(products * mean_);
      noise_ = std::max(
          kMinNoise, std::sqrt(std::max(rss, 0.0) / (effective_sample_fraction_ * problem_.rows)));
    }
    solve(products, targets);
  }

  void solve(const Eigen::MatrixXd& products, const Eigen::VectorXd& targets) {
    Eigen::MatrixXd H = products / (noise_ * noise_);
    for (Eigen::Index j = 0; j < H.rows(); ++j) {
      const double s =
          j < problem_.known() ? problem_.known_std[j] : strength_[j - problem_.known()];
      H(j, j) += 1.0 / (s * s);
    }
    factor_ = factored(std::move(H));
    mean_ = factor_.solve(targets / (noise_ * noise_));
  }

  Gains gainsOf() const {
    const Eigen::Index free = problem_.products.cols() - problem_.known();
    const double beta = effective_sample_fraction_ / (noise_ * noise_);
    const Eigen::MatrixXd cross =
        beta * problem_.products(index_, Eigen::seqN(problem_.known(), free));
    const Eigen::VectorXd S = beta * problem_.products.diagonal().tail(free) -
                              cross.cwiseProduct(factor_.solve(cross)).colwise().sum().transpose();
    const Eigen::VectorXd Q = beta * problem_.targets.tail(free) - cross.transpose() * mean_;
    Gains gains;
    gains.own = Eigen::VectorXd::Zero(columns_.size());
    for (int k = 0; k < free; ++k) {
      const auto chosen = std::find(columns_.begin(), columns_.end(), k);
      double s = S[k], q = Q[k];
      if (chosen != columns_.end()) {
        const double alpha = std::pow(strength_[chosen - columns_.begin()], -2);
        const double left = std::max(alpha - s, 1e-12 * alpha);
        s = alpha * s / left;
        q = alpha * q / left;
      }
      if (!(s > 0.0)) continue;
      const double variance = std::min((q * q - s) / (s * s), kMaxSparse * kMaxSparse);
      if (chosen != columns_.end()) {
        gains.own[chosen - columns_.begin()] = variance;
        continue;
      }
      if (!(variance > 0.0)) continue;
      const double gain =
          0.5 * q * q * variance / (1.0 + variance * s) - 0.5 * std::log1p(variance * s) - 1.0;
      if (gain <= gains.gain) continue;
      gains.gain = gain;
      gains.best = k;
      gains.strength = std::sqrt(variance);
    }
    return gains;
  }

  /// Takes the chosen columns' strengths again. @return whether one was dropped.
  bool update(const Gains& gains) {
    for (std::size_t j = 0; j < columns_.size(); ++j) {
      const double variance = gains.own[j];
      if (variance > 1e-13) {
        strength_[j] = std::sqrt(variance);
        continue;
      }
      const int gone = columns_[j];
      columns_.erase(columns_.begin() + j);
      strength_.erase(strength_.begin() + j);
      path_.erase(std::find_if(path_.begin(), path_.end(),
                               [gone](const SparseStep& step) { return step.column == gone; }));
      return true;
    }
    return false;
  }

  SparseFit result() const {
    SparseFit sparse;
    LinearFit& fit = sparse.fit;
    fit.z = Eigen::VectorXd::Zero(problem_.products.cols());
    fit.z(index_) = mean_;
    fit.strength.assign(problem_.products.cols() - problem_.known(), 0.0);
    for (std::size_t j = 0; j < columns_.size(); ++j) fit.strength[columns_[j]] = strength_[j];
    fit.noise = noise_;
    for (const SparseStep& step : path_) fit.evidence += step.gain;
    sparse.path = path_;
    return sparse;
  }

  const LinearProblem& problem_;
  double effective_sample_fraction_, noise_ = 1.0;
  std::vector<int> columns_;
  std::vector<double> strength_;
  std::vector<SparseStep> path_;
  std::vector<Eigen::Index> index_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd mean_;
};

}  // namespace

LinearFit fitSomeGroups(const LinearProblem& problem, double effective_sample_fraction,
                        const std::vector<char>& active) {
  const GroupSearch search(problem, effective_sample_fraction, active);
  const LinearFit small = search.run(std::vector<double>(active.size(), GroupPrior::kFirst),
                                     firstNoise(problem), kRounds);
  const LinearFit large =
      search.run(std::vector<double>(active.size(), 0.6 * GroupPrior::kMost), small.noise, kRounds);
  return better(sound(problem, effective_sample_fraction, small),
                sound(problem, effective_sample_fraction, large));
}

LinearFit fitGroups(const LinearProblem& problem, double effective_sample_fraction) {
  const std::vector<char> all(problem.groups, 1);
  const LinearFit plain = fitSomeGroups(problem, effective_sample_fraction, all);
  const LinearFit taken = greedy(problem, effective_sample_fraction);
  return better(plain, fitGroupsFrom(problem, effective_sample_fraction, taken));
}

LinearFit fitGroupsFrom(const LinearProblem& problem, double effective_sample_fraction,
                        const LinearFit& start) {
  std::vector<double> from = start.strength;
  for (double& s : from) s = std::max(s, kMinStrength);
  return GroupSearch(problem, effective_sample_fraction).run(from, start.noise, kRounds);
}

Eigen::MatrixXd covarianceOf(const LinearProblem& problem, double effective_sample_fraction,
                             const LinearFit& fit) {
  if (!std::isfinite(fit.evidence)) return Eigen::MatrixXd::Zero(fit.z.size(), fit.z.size());
  return GroupSearch(problem, effective_sample_fraction).covarianceOf(fit);
}

double evidenceOfUnitPriors(const Eigen::MatrixXd& products, const Eigen::VectorXd& targets,
                            double square, double rows, double effective_sample_fraction,
                            double noise) {
  const auto axes = eigenDecomposition(effective_sample_fraction * products);
  const Eigen::ArrayXd spectrum = axes.eigenvalues().array().max(0.0);
  const Eigen::ArrayXd squares =
      (effective_sample_fraction * (axes.eigenvectors().transpose() * targets)).array().square();
  const double y2 = effective_sample_fraction * square, n = effective_sample_fraction * rows;
  double s = noise;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::ArrayXd kept = spectrum + s * s;
    const double residual = y2 - (2.0 * squares / kept - spectrum * squares / kept.square()).sum();
    const double next = std::max(
        kMinNoise,
        std::sqrt(std::max(residual, 0.0) / std::max(n - (spectrum / kept).sum(), 0.1 * n)));
    if (std::abs(next - std::exchange(s, next)) < kSettledNoise * next) break;
  }
  const Eigen::ArrayXd kept = spectrum + s * s;
  return -0.5 * n * std::log(kTwoPi * s * s) - 0.5 * (y2 - (squares / kept).sum()) / (s * s) -
         0.5 * (kept / (s * s)).log().sum();
}

SparseFit fitSparse(const LinearProblem& problem, double effective_sample_fraction,
                    int max_columns) {
  return SparseSearch(problem, effective_sample_fraction).run(max_columns);
}

double independentShare(const Eigen::VectorXd& residual) {
  const Eigen::Index count = residual.size();
  const double mean = count > 0 ? residual.mean() : 0.0;
  std::size_t length = 1;  // zeros keep the ends apart, and fill up to what transforms fast
  while (length < static_cast<std::size_t>(2 * count)) length *= 2;
  std::vector<double> e(length, 0.0);
  for (Eigen::Index n = 0; n < count; ++n) e[n] = residual[n] - mean;
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, e);
  for (auto& line : spectrum) line = std::norm(line);
  std::vector<double> products;
  fft.inv(products, spectrum);
  double sum = 0.0;
  for (std::size_t lag = 1; lag < static_cast<std::size_t>(count) / 10 && products[lag] > 0.0;
       ++lag)
    sum += products[lag] / products[0];
  return 1.0 / (1.0 + 2.0 * sum);
}

}  // namespace battery_sof
