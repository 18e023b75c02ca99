#include "explanation_fits.hpp"

#include <limits>
#include <stdexcept>

namespace battery_sof {
namespace {

// instruments' errors hang together for seconds, what lasts longer is physics
constexpr double kMinSampleFraction = 0.02;
// the same from any state before
constexpr double kFirstSampleFraction = 0.05, kSettledSampleFraction = 1e-4;
constexpr int kSampleFractionPasses = 8, kPolishes = 2;
constexpr double kPolished = 1e-3;  // ln evidence
constexpr double kHeavyDischarge = -100.0, kChargeCurrent = 5.0, kTypicalCharge = 30.0;  // [A]
// steps of a voltage channel's random walk over the training part
constexpr int kRandomWalk = 24;
constexpr double kMaxRandomWalk = 0.0012;  // [V] a root minute, of a voltage channel
constexpr double kDiverged = 1e6;          // [V], a row or what a coordinate's unit moves it by
constexpr double kShort = 120.0;           // [s] of a training part; seldom more than one crank

}  // namespace

Eigen::MatrixXd ExplanationColumns::times(const Eigen::MatrixXd& z) const {
  return own * z.topRows(own.cols()) + (*free)(Eigen::all, used) * z.bottomRows(used.size());
}

Eigen::MatrixXd ExplanationColumns::ofRows(IndexRange rows) const {
  Eigen::MatrixXd some(rows.size(), own.cols() + static_cast<Eigen::Index>(used.size()));
  some << own(rowsOf(rows), Eigen::all), (*free)(rowsOf(rows), used);
  return some;
}

Eigen::VectorXd ExplanationColumns::along(const Eigen::VectorXd& v) const {
  Eigen::VectorXd products(own.cols() + static_cast<Eigen::Index>(used.size()));
  products.head(own.cols()) = own.transpose() * v;
  for (std::size_t j = 0; j < used.size(); ++j)
    products[own.cols() + static_cast<Eigen::Index>(j)] = free->col(used[j]).dot(v);
  return products;
}

ExplanationFits::ExplanationFits(const InputSequence& inputs, const CompositionPoint& base,
                                 const DiagnoseOptions& options)
    : options_(options),
      base_(base),
      response_(linearizationOf(BatteryModel(), base.at(inputs.first_time), inputs,
                                inputs.samples.size())),
      table_(designMatrix(inputs, response_, base.parameters[kRowBeta])),
      rows_(inputs, response_, base) {
  for (Eigen::Index row = 0; row < response_.training; ++row)
    if (response_.weight[row] > 0.0) counted_.push_back(row);
  takeFree();
  noise_ = TimingJitterNoise(inputs, response_, counted_);
  takeWhitening(noise_.with(0.0, 0.0));
  takeRelevance();
}

const std::optional<ExplanationState>& ExplanationFits::placedBase() {
  if (base_state_) return base_state_;
  ExplanationState state;
  state.point = base_;
  state.coordinates = coordinatesOf(state.model);
  if (!linearize(state)) return base_state_;
  takeNoise(state);
  base_state_ = std::move(state);
  return base_state_;
}

ExplanationState ExplanationFits::baseState() {
  if (!placedBase())
    throw std::invalid_argument("explain: the base circuit has no finite voltage where it begins");
  return *base_state_;
}

Eigen::VectorXd ExplanationFits::errorsOf(const BatteryModel& model,
                                          const CompositionPoint& point) const {
  pulse();
  const RowErrors errors = rows_.errors(model, point);
  return errors.error.size() > 0 ? Eigen::VectorXd(errors.error(counted_)) : Eigen::VectorXd();
}

bool ExplanationFits::linearize(ExplanationState& state) const {
  pulse();
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(
      state.model.parameterCount() + state.model.stateCount(), state.coordinates.size());
  for (std::size_t j = 0; j < state.coordinates.size(); ++j) {
    const FitCoordinate& c = state.coordinates[j];
    seeds(c.row, j) = c.slope(state.point[c.row]);
  }
  const RowErrors errors = rows_.errors(state.model, state.point, seeds);
  if (errors.error.size() == 0) return false;
  state.error = errors.error(counted_);
  state.sensitivity = errors.sensitivity(counted_, Eigen::all);
  return std::max(rms(state.error), state.sensitivity.cwiseAbs().maxCoeff()) < kDiverged;
}

Eigen::VectorXd ExplanationFits::expectedFrom(const ExplanationState& state, Eigen::VectorXd& std) {
  const Eigen::Index known = state.coordinates.size();
  Eigen::VectorXd expected(known);
  std.resize(known);
  for (Eigen::Index j = 0; j < known; ++j) {
    const FitCoordinate& c = state.coordinates[j];
    expected[j] = c.centre - c.of(state.point[c.row]);
    std[j] = c.std;
  }
  return expected;
}

ExplanationSums ExplanationFits::sumsOf(const ExplanationState& state, bool all) const {
  ExplanationSums sums;
  LinearProblem& problem = sums.problem;
  const Eigen::VectorXd expected = expectedFrom(state, problem.known_std);
  const Eigen::Index known = expected.size();
  std::vector<Eigen::Index>& used = sums.columns.used;
  for (std::size_t k = 0; k < table_.regressors.size(); ++k)
    if (all || state.estimated.count(table_.regressors[k].mechanism)) {
      used.push_back(k);
      problem.group.push_back(static_cast<int>(groupOf(table_.regressors[k].kind)));
    }
  problem.group.insert(problem.group.end(), kRandomWalk, kRegressorGroups);
  problem.groups = kRegressorGroups + 1;
  problem.most.assign(kRegressorGroups + 1, GroupPrior::kMost);
  problem.most.back() = max_random_walk_;
  for (int k = 0; k < kRandomWalk; ++k)
    used.push_back(static_cast<Eigen::Index>(table_.regressors.size()) + k);
  const Eigen::Index free = used.size();
  Eigen::MatrixXd& own = sums.columns.own;
  own = noise_.whitened(state.sensitivity);
  sums.columns.free = &whitenedFree();
  sums.targets = whitened(state.error - state.sensitivity * expected);
  problem.products.resize(known + free, known + free);
  problem.products.topLeftCorner(known, known) = own.transpose() * own;
  problem.products.bottomLeftCorner(free, known) =
      whitenedFree()(Eigen::all, used).transpose() * own;
  problem.products.topRightCorner(known, free) =
      problem.products.bottomLeftCorner(free, known).transpose();
  problem.products.bottomRightCorner(free, free) = free_products_(used, used);
  problem.targets = sums.columns.along(sums.targets);
  problem.square = sums.targets.squaredNorm();
  problem.rows = static_cast<double>(counted_.size());
  return sums;
}

ExplanationSums ExplanationFits::evaluateEvidence(ExplanationState& state) const {
  ExplanationSums sums = sumsOf(state, false);
  state.fit = fitOf(sums.problem);
  state.evidence = state.fit.evidence + effective_sample_fraction_ * noise_.logScale();
  return sums;
}

void ExplanationFits::begin(ExplanationState& state, int iterations) const {
  state.evidence = -std::numeric_limits<double>::infinity();
  if (!linearize(state)) return;
  evaluateEvidence(state);
  improve(state, iterations);
}

void ExplanationFits::optimize(ExplanationState& state) {
  evaluateEvidence(state);
  const auto key = std::make_pair(std::set<std::string>(state.members.begin(), state.members.end()),
                                  state.estimated);
  ExplanationState other = state;
  if (takeKnown(key, other)) {
    if (linearize(other)) evaluateEvidence(other);
    if (other.evidence > state.evidence) state = std::move(other);
  }
  improve(state);
  if (!std::isfinite(state.evidence)) return;
  const std::lock_guard<std::mutex> lock(known_mutex_);
  known_.insert_or_assign(key, std::make_pair(state.model, state.point));
}

bool ExplanationFits::takeKnown(const Parts& parts, ExplanationState& state) {
  const std::lock_guard<std::mutex> lock(known_mutex_);
  const auto known = known_.find(parts);
  if (known == known_.end()) return false;
  state.point = movedTo(state.model, known->second.first, known->second.second);
  return true;
}

void ExplanationFits::pulse() const {
  if (options_.pulse && std::this_thread::get_id() == caller_) options_.pulse();
}

void ExplanationFits::refine(ExplanationState& state) {
  for (int round = 0; round <= kPolishes; ++round) {
    takeNoise(state);
    evaluateEvidence(state);
    const double before = state.evidence;
    if (round < kPolishes) improve(state, kMaxIterations, kPolished);
    if (state.evidence - before < kPolished) return;
  }
}

void ExplanationFits::takeNoise(const ExplanationState& state) {
  takeWhitening(noise_.with(0.0, 0.0));  // the same from any state before
  const LinearFit all = takeEffectiveSampleFraction(state);
  if (!noise_.applies()) return;
  ExplanationSums sums = sumsOf(state, true);
  const NoiseRows rows{
      sums.columns.times(NoiseRows::directions(sums.problem, all, effective_sample_fraction_)),
      std::move(sums.targets), effective_sample_fraction_, all.noise};
  takeWhitening(noise_.best([&](const TimingJitterNoise& noise) { return rows.evidence(noise); }));
  takeEffectiveSampleFraction(state);
}

double ExplanationFits::minError() {
  const std::optional<ExplanationState>& base = placedBase();
  if (!base) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd z = fitOf(sumsOf(*base, true).problem).z;
  Eigen::VectorXd std;
  const Eigen::VectorXd moved = expectedFrom(*base, std) + z.head(base->coordinates.size());
  return rms(base->error - base->sensitivity * moved - free_ * z.tail(free_.cols()));
}

void ExplanationFits::takeWhitening(const TimingJitterNoise& noise) {
  noise_ = noise;
  whitened_.resize(0, 0);
  if (noise_.isWhite() && white_products_.size() > 0) {
    free_products_ = white_products_;
    return;
  }
  if (!noise_.isWhite()) whitened_ = noise_.whitened(free_);
  free_products_.setZero(free_.cols(), free_.cols());
  free_products_.selfadjointView<Eigen::Lower>().rankUpdate(whitenedFree().transpose());
  free_products_.triangularView<Eigen::StrictlyUpper>() = free_products_.transpose();
  if (noise_.isWhite()) white_products_ = free_products_;
}

LinearFit ExplanationFits::takeEffectiveSampleFraction(const ExplanationState& state) {
  effective_sample_fraction_ = kFirstSampleFraction;
  const ExplanationSums sums = sumsOf(state, true);
  LinearFit fit;
  for (int pass = 0; pass < kSampleFractionPasses; ++pass) {
    fit = pass == 0 ? fitGroups(sums.problem, effective_sample_fraction_)
                    : fitGroupsFrom(sums.problem, effective_sample_fraction_, fit);
    const double before = std::exchange(
        effective_sample_fraction_,
        std::max(kMinSampleFraction, independentShare(sums.targets - sums.columns.times(fit.z))));
    if (std::abs(effective_sample_fraction_ - before) < kSettledSampleFraction * before) break;
  }
  return fit;
}

ExplanationState ExplanationFits::withRegressors(const ExplanationState& state,
                                                 Mechanism mechanism) const {
  ExplanationState next = state;
  next.estimated.insert(mechanism);
  evaluateEvidence(next);
  return next;
}

ExplanationState ExplanationFits::withoutMembers(ExplanationState& state,
                                                 const std::set<std::string>& ids) {
  ExplanationState next = state;
  const auto isOut = [&](const std::string& id) { return ids.count(id) > 0; };
  next.members.erase(std::remove_if(next.members.begin(), next.members.end(), isOut),
                     next.members.end());
  next.model = BatteryModel();
  for (const std::string& other : next.members)
    if (!next.has(other)) next.model = enlarged(next.model, other);
  next.coordinates = coordinatesOf(next.model);
  next.point = movedTo(next.model, state.model, state.point);
  if (!linearize(next)) {
    next.point = embedded(BatteryModel(), base_, next.model);
    if (!linearize(next))
      throw std::invalid_argument("explain: the base circuit has no finite voltage");
  }
  optimize(next);
  ExplanationState again = state;
  takeShared(next.model, next.point, again.model, again.point);
  if (linearize(again)) takeBetter(state, std::move(again));
  return next;
}

ExplanationState ExplanationFits::withoutRegressors(ExplanationState& state, Mechanism mechanism) {
  ExplanationState next = state;
  next.estimated.erase(mechanism);
  optimize(next);
  takeBetter(state, withRegressors(next, mechanism));
  return next;
}

void ExplanationFits::takeBetter(ExplanationState& state, ExplanationState again) {
  evaluateEvidence(again);
  if (!(again.evidence > state.evidence)) return;
  optimize(again);
  again.explained = state.explained;
  again.structure_gain = state.structure_gain;
  state = std::move(again);
}

Eigen::MatrixXd ExplanationFits::penalised(const ExplanationSums& sums,
                                           const ExplanationState& state) const {
  Eigen::MatrixXd H = sums.problem.products;
  for (Eigen::Index k = 0; k < H.rows(); ++k) {
    const double s = k < sums.problem.known()
                         ? sums.problem.known_std[k]
                         : std::max(state.fit.strength[sums.problem.groupOf(k)], 1e-6);
    H(k, k) += state.fit.noise * state.fit.noise / (effective_sample_fraction_ * s * s);
  }
  return H;
}

Eigen::VectorXd ExplanationFits::modelled(const ExplanationState& state) const {
  const Eigen::Index known = state.coordinates.size();
  Eigen::VectorXd said = -state.error;
  Eigen::Index j = known;
  for (std::size_t k = 0; k < table_.regressors.size(); ++k)
    if (state.estimated.count(table_.regressors[k].mechanism))
      said += free_.col(k) * state.fit.z[j++];
  return said;
}

Eigen::VectorXd ExplanationFits::unexplainedPart(const ExplanationState& state) const {
  const LinearFit all = fitOf(sumsOf(state, true).problem);
  Eigen::VectorXd part = Eigen::VectorXd::Zero(free_.rows());
  for (std::size_t k = 0; k < table_.regressors.size(); ++k)
    if (!state.estimated.count(table_.regressors[k].mechanism))
      part += free_.col(k) * all.z[state.coordinates.size() + k];
  return part;
}

Eigen::VectorXd ExplanationFits::beyondBase(const Eigen::VectorXd& part) const {
  const Eigen::MatrixXd J = response_.sensitivity(counted_, Eigen::all);
  Eigen::MatrixXd H = J.transpose() * J;
  H.diagonal().array() += 1e-9 * H.diagonal().array();
  return part - J * H.ldlt().solve(J.transpose() * part);
}

double ExplanationFits::crankOf(const Eigen::VectorXd& part) const {
  double sum = 0.0, cranks = 0.0;
  for (std::size_t n = 0; n < counted_.size(); ++n) {
    if (!(rows_.currentOf(counted_[n]) < kHeavyDischarge)) continue;
    sum += std::abs(part[n]);
    cranks += 1.0;
  }
  return cranks > 0.0 ? sum / cranks : 0.0;
}

double ExplanationFits::chargeShareOf(const Eigen::VectorXd& part) const {
  double charge = 0.0, currents = 0.0;
  for (std::size_t n = 0; n < counted_.size(); ++n) {
    const double current = rows_.currentOf(counted_[n]);
    if (!(current > kChargeCurrent)) continue;
    charge += std::abs(part[n]);
    currents += current;
  }
  const double resistance =
      base_.parameters[kRowRCharge] + 2.0 / base_.parameters[kRowBeta] / kTypicalCharge;
  return currents > 0.0 ? charge / resistance / currents : 0.0;
}

LinearFit ExplanationFits::fitOf(const LinearProblem& problem) const {
  std::vector<char> active(kRegressorGroups + 1, 0);
  for (const int group : problem.group) active[group] = 1;
  return fitSomeGroups(problem, effective_sample_fraction_, active);
}

bool ExplanationFits::isShort() const { return table_.context.span < kShort; }

double ExplanationFits::beyond(const ExplanationState& more, const ExplanationState& less) {
  return std::sqrt(std::max(0.0, std::pow(less.fit.noise, 2) - std::pow(more.fit.noise, 2)));
}

void ExplanationFits::takeFree() {
  const Eigen::Index rows = counted_.size(), columns = table_.values.cols();
  free_ = std::move(table_.values);
  if (rows < free_.rows()) free_ = free_(counted_, Eigen::all).eval();
  free_.conservativeResize(rows, columns + kRandomWalk);
  const double from = response_.time[counted_.front()],
               length = (response_.time[counted_.back()] - from) / kRandomWalk;
  for (std::size_t n = 0; n < counted_.size(); ++n)
    for (int k = 0; k < kRandomWalk; ++k)
      free_(n, columns + k) =
          std::clamp((response_.time[counted_[n]] - from) / length - k, 0.0, 1.0);
  max_random_walk_ = kMaxRandomWalk * std::sqrt(length / 60.0);
}

void ExplanationFits::takeRelevance() {
  double square = 0.0, currents = 0.0, controlled = 0.0;
  for (const Eigen::Index row : counted_) {
    if (!response_.voltage_controlled[row]) continue;
    square += std::pow(rows_.currentOf(row) * response_.resistance[row], 2);
    controlled += 1.0;
  }
  if (controlled > 0.0) currents = options_.relevance.charge_share * std::sqrt(square / controlled);
  const double share = controlled / static_cast<double>(counted_.size()),
               rmse = options_.relevance.rmse;
  relevant_ =
      std::sqrt((1.0 - share) * rmse * rmse + share * std::pow(std::max(rmse, currents), 2));
}

CompositionPoint ExplanationFits::movedTo(const BatteryModel& model, const BatteryModel& from,
                                          const CompositionPoint& there) const {
  CompositionPoint point = embedded(BatteryModel(), base_, model);
  takeShared(from, there, model, point);
  return point;
}

}  // namespace battery_sof
