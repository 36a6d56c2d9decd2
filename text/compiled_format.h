// Included in every file by deploy/cmake/MotiondbTarget.cmake. spdlog and fmt::format_to call a
// template that libfmt exports, but fmt 9 does not declare as exported: without this declaration
// each file compiles the formatting of all types again, which takes 1 to 3 s.
#pragma once

#include <fmt/format.h>

extern template void fmt::detail::vformat_to<char>(
    fmt::detail::buffer<char>& to, fmt::string_view format,
    fmt::basic_format_args<fmt::buffer_context<char>> arguments, fmt::detail::locale_ref locale);
