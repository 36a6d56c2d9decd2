// Products of a few rows with a matrix, faster than Eigen's, which knows no processor newer than
// the oldest. Pure; safe to call from any thread.
#pragma once

#include "core/motion/matrix.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {

// rows * matrix. REQUIRES: rows.cols() == matrix.rows().
inline FrameMatrix RowProduct(const FrameMatrix& rows, const FrameMatrix& matrix) {
  FrameMatrix product(rows.rows(), matrix.cols());
  MultiplyRows(rows.data(), static_cast<int>(rows.rows()), static_cast<int>(rows.cols()),
               matrix.data(), static_cast<int>(matrix.cols()), product.data());
  return product;
}

}  // namespace motiondb::core
