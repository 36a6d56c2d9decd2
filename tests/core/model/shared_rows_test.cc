#include "core/model/shared_rows.h"

#include <catch2/catch.hpp>
#include <utility>

namespace motiondb::tests::shared_rows_test {

TEST_CASE("SharedRows: moves the first rows instead of copying them", "[core][model]") {
  core::FrameMatrix first = core::FrameMatrix::Random(40, 3);
  const core::FrameMatrix expected = first;
  const float* const memory = first.data();
  const core::SharedRows rows = core::SharedRows().WithMore(std::move(first));
  CHECK(rows.view().data() == memory);
  CHECK(rows.view() == expected);
  CHECK(core::SharedRows().rows() == 0);
}

TEST_CASE("SharedRows: appends rows without changing existing ones", "[core][model]") {
  const core::FrameMatrix all = core::FrameMatrix::Random(90, 3);
  const core::SharedRows first(all.topRows(80));
  const core::SharedRows copied = first.WithMore(all.middleRows(80, 2));
  CHECK(copied.view().data() != first.view().data());
  CHECK(copied.view() == all.topRows(82));
  // The copy has capacity for an eighth more: the next rows use it.
  const core::SharedRows grown = copied.WithMore(all.bottomRows(8));
  CHECK(grown.view().data() == copied.view().data());
  CHECK(grown.view() == all);
  // The capacity is used, so another extension copies the rows.
  const core::FrameMatrix other_rows = core::FrameMatrix::Constant(8, 3, 7);
  const core::SharedRows second_copy = copied.WithMore(other_rows);
  CHECK(second_copy.view().data() != copied.view().data());
  CHECK(second_copy.view().bottomRows(8) == other_rows);
  CHECK(grown.view() == all);
  CHECK(copied.view() == all.topRows(82));
  CHECK(first.view() == all.topRows(80));
}

}  // namespace motiondb::tests::shared_rows_test
