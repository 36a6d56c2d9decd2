// By what a question is answered.
#pragma once

namespace motiondb::core {

enum class Method {
  kBest,   // the tree and its graphs, then stored frames compared with the observation
  kPaper,  // the tree and its graphs alone, as in the paper
};

}  // namespace motiondb::core
