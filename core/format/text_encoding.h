// Text of unknown encoding -> UTF-8. Motion files carry names in whatever their writer's machine
// used. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace motiondb::core {

// `bytes` as they are if they are valid UTF-8, or else read as Latin-1. Display controls become
// '?'. The result is always valid UTF-8.
std::string ToUtf8(std::string_view bytes);

}  // namespace motiondb::core
