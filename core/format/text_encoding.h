// Text of unknown encoding -> UTF-8, and what of it may be displayed. Motion files carry names in
// whatever their writer's machine used. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace motiondb::core {

struct Utf8Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0: the text does not begin with well-formed UTF-8
};

// The first character of a text that is not empty (Unicode, table 3-7).
Utf8Character FirstUtf8Character(std::string_view text);

// Whether a character is a display control: it moves a cursor, ends a line, reverses or joins the
// text around it, or is forbidden in XML. C0 and C1 controls with DEL, line and paragraph
// separators, marks and overrides of the writing direction, deprecated format characters, the byte
// order mark, interlinear annotation, U+FFFE and U+FFFF.
bool IsDisplayControl(char32_t character);

// The first display control of a valid UTF-8 text; 0 bytes if it has none.
Utf8Character FindDisplayControl(std::string_view text);

// The text with U+FFFD for each display control, and for each byte that is not UTF-8.
std::string WithoutDisplayControls(std::string_view text);

// `bytes` as they are if they are valid UTF-8, or else read as Latin-1. Display controls become
// '?'. The result is always valid UTF-8.
std::string ToUtf8(std::string_view bytes);

}  // namespace motiondb::core
