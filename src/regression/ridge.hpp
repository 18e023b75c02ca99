#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

namespace battery_sof {

/// How a ridge regression is chosen.
struct RidgeOptions {
  /// [1], tried one by one; those of the normal equations of scaled columns
  std::vector<double> penalties;
  int blocks = 6;                 ///< consecutive blocks of the cross-validation
  double constant_penalty = 0.0;  ///< share of the penalty that the constant bears [1]
  /// penalties are those of the mean over the rows that are fitted, not of their sum
  bool of_mean = false;
  bool clipped = false;  ///< columns are held inside what the fit saw
  /// the prediction is scaled by what the left-out blocks ask for, in [0, 1]
  bool shrunk = false;
};

/**
 * @brief A linear prediction of one number from columns: y = constant + sum_j weight_j (x_j -
 * centre_j) / scale_j.
 *
 * Default-constructed it predicts zero.
 */
struct RidgeFit {
  Eigen::VectorXd centre, scale, weight;  ///< one a column; columns that never moved weigh nothing
  Eigen::VectorXd lower, upper;           ///< columns are held inside these; empty: they are not
  double constant = 0.0;
  double penalty = 0.0;  ///< the one chosen, as given
  /// 1 - squared error of the left-out blocks over that of predicting zero [1]
  double gain = 0.0;
  bool empty() const { return weight.size() == 0; }
  double at(const Eigen::Ref<const Eigen::VectorXd>& columns) const;
  /// What column j adds to the constant in every row; all columns together make at(). @param values
  /// of that column.
  Eigen::VectorXd ofColumn(Eigen::Index j, const Eigen::Ref<const Eigen::VectorXd>& values) const;
};

/**
 * @brief Ridge regression with a penalty chosen by leaving consecutive blocks out.
 *
 *     w = argmin sum_n (y_n - c - w' z_n)^2 + lambda (|w|^2 + p c^2),   z: columns less their mean, by their deviation
 *
 * lambda is a penalty, or the number of rows times it (of_mean).
 *
 * @param X    one row a sample.  @param y as many.
 * @param left_out set to the prediction of every sample by a fit without its block, scaled like the
 * fit's own; nullptr: not needed.
 * @return a fit that predicts zero when leaving out shows no gain and `shrunk` is set.
 * @throws std::invalid_argument when sizes differ, there are fewer rows than twice the blocks, or
 * no penalty is given.
 */
RidgeFit fitRidge(const Eigen::MatrixXd& X, const Eigen::VectorXd& y, const RidgeOptions& options,
                  Eigen::VectorXd* left_out = nullptr);

/**
 * @brief The normal equations of a few columns under one given penalty: (lambda 1 + sum w f f') x =
 * sum w f y.
 */
template <int N>
class RidgeSums {
 public:
  using Columns = Eigen::Matrix<double, N, 1>;

  explicit RidgeSums(double penalty) : products_(penalty * Products::Identity()) {}
  /// @param weight of the row; -1 takes one out that was added with 1.
  void add(const Columns& f, double y, double weight = 1.0) {
    products_ += weight * f * f.transpose();
    targets_ += weight * y * f;
  }
  double at(const Columns& f) const { return f.dot(products_.ldlt().solve(targets_)); }

 private:
  using Products = Eigen::Matrix<double, N, N>;

  Products products_;
  Columns targets_ = Columns::Zero();
};

}  // namespace battery_sof
