// Matrices of floats on a byte stream, without their size: it follows from fields before them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "storage/blob/fields.h"

namespace motiondb::storage {

template <typename Matrix>
void PutMatrix(FieldWriter& writer, const Matrix& matrix) {
  writer.PutElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

// Fails before memory is taken where so many numbers cannot follow.
template <typename Matrix>
void GetMatrix(FieldReader& reader, Eigen::Index rows, Eigen::Index columns, Matrix& matrix) {
  if (!reader.ok()) return;
  // Divided, since the product of two counts that a damaged blob has may not fit a number.
  const std::uint64_t numbers = reader.remaining() / sizeof(float);
  if (rows != 0 &&
      static_cast<std::uint64_t>(columns) > numbers / static_cast<std::uint64_t>(rows)) {
    return reader.Fail(core::DataLoss("expected {} x {} numbers, got {} bytes", rows, columns,
                                      reader.remaining()));
  }
  matrix.resize(rows, columns);
  reader.GetElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

}  // namespace motiondb::storage
