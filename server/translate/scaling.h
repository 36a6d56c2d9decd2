// core::Scaling -> v1::Scaling.
#pragma once

#include "core/tree/feature_scale.h"
#include "motiondb/v1/database.pb.h"

namespace motiondb::server {

inline v1::Scaling ToProto(core::Scaling scaling) {
  switch (scaling) {
    case core::Scaling::kNone:
      return v1::SCALING_NONE;
    case core::Scaling::kKind:
      return v1::SCALING_KIND;
    case core::Scaling::kDimension:
      return v1::SCALING_DIMENSION;
  }
  return v1::SCALING_UNSPECIFIED;
}

}  // namespace motiondb::server
