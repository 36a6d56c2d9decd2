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
  const auto bytes = sizeof(float) * static_cast<std::uint64_t>(rows) * columns;
  if (bytes > reader.remaining()) {
    return reader.Fail(core::DataLoss("expected {} bytes, got {}", bytes, reader.remaining()));
  }
  matrix.resize(rows, columns);
  reader.GetElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

}  // namespace motiondb::storage
