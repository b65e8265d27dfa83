// Running sums for a least-squares surface of degree two, w = a x + b y + c + d x^2 + e x y + f
// y^2: adding patches or regions keeps them, so that a merge costs O(1). Encoder half; plain
// doubles.
#pragma once

#include <cmath>

#include "core/model/float_surface.hpp"

namespace planecast {

/// Readings of a small patch: their weight, means, mean products about the means, slopes of their
/// own plane and mean squared distance from it.
struct QuadricPatch {
  double weight, x, y, w, xx, xy, yy, a, b, own;
};

/// Weighted normal equations over (1, x, y, x^2, x y, y^2). All calls O(1), no allocation.
struct QuadricSums {
  static constexpr int kTerms = 6;
  double n = 0;            ///< sum of weights
  double matrix[21] = {};  ///< lower triangle by rows
  double vector[kTerms] = {};
  double ww = 0;

  /// Adds a patch over which x^2 - the like in x y and y^2 - bends little: within it the terms are
  /// taken as linear, with their exact means.
  void add_patch(const QuadricPatch& p) noexcept {
    const double mean[kTerms] = {1, p.x, p.y, p.x * p.x + p.xx, p.x * p.y + p.xy, p.y * p.y + p.yy};
    const double along_x[kTerms] = {0, 1, 0, 2 * p.x, p.y, 0};
    const double along_y[kTerms] = {0, 0, 1, 0, p.x, 2 * p.y};
    const double xw = p.a * p.xx + p.b * p.xy, yw = p.a * p.xy + p.b * p.yy;
    n += p.weight;
    double* row = matrix;
    for (int i = 0; i < kTerms; ++i) {
      const double first = p.weight * mean[i];
      const double second = p.weight * (p.xx * along_x[i] + p.xy * along_y[i]);
      const double third = p.weight * (p.xy * along_x[i] + p.yy * along_y[i]);
      for (int j = 0; j <= i; ++j) {
        row[j] += first * mean[j] + second * along_x[j] + third * along_y[j];
      }
      row += i + 1;
      vector[i] += first * p.w + p.weight * (xw * along_x[i] + yw * along_y[i]);
    }
    ww += p.weight * (p.own + p.a * xw + p.b * yw + p.w * p.w);
  }

  void add(const QuadricSums& other) noexcept {
    n += other.n;
    for (int i = 0; i < 21; ++i) matrix[i] += other.matrix[i];
    for (int i = 0; i < kTerms; ++i) vector[i] += other.vector[i];
    ww += other.ww;
  }

  /// Least-squares surface, and its mean squared distance from the readings; false when they do
  /// not span one.
  bool solve(FloatSurface& out, double& mean_square) const noexcept {
    if (!(n > 0)) return false;
    // Cholesky; w about its mean, so that the distance does not cancel.
    double l[21], solved[kTerms];
    const double mw = vector[0] / n;
    double rest = ww - mw * vector[0];
    for (int i = 0, at_i = 0; i < kTerms; at_i += ++i) {
      for (int j = 0, at_j = 0; j <= i; at_j += ++j) {
        double sum = matrix[at_i + j];
        for (int k = 0; k < j; ++k) sum -= l[at_i + k] * l[at_j + k];
        if (j < i) {
          l[at_i + j] = sum / l[at_j + j];
        } else {
          if (!(sum > 1e-11 * matrix[at_i + i])) return false;
          l[at_i + i] = std::sqrt(sum);
        }
      }
      double sum = vector[i] - mw * matrix[at_i];
      for (int k = 0; k < i; ++k) sum -= l[at_i + k] * solved[k];
      solved[i] = sum / l[at_i + i];
      rest -= solved[i] * solved[i];
    }
    double c[kTerms];
    for (int i = kTerms - 1; i >= 0; --i) {
      double sum = solved[i];
      for (int k = i + 1; k < kTerms; ++k) sum -= l[k * (k + 1) / 2 + i] * c[k];
      c[i] = sum / l[i * (i + 1) / 2 + i];
    }
    out = {c[1], c[2], c[0] + mw, c[3], c[4], c[5]};
    mean_square = rest > 0 ? rest / n : 0;
    return true;
  }
};

}  // namespace planecast
