// Words in a picture: ASCII in a small fixed font, enlarged by whole numbers.
#pragma once

#include <cstdint>
#include <string_view>

#include "apps/common/picture.hpp"

namespace planecast {

/// Size [px] of text drawn at `scale` (1: letters of 5 x 7 in cells of 6 x 8).
std::uint32_t text_width(std::string_view text, std::uint32_t scale);
std::uint32_t text_height(std::uint32_t scale);

/// Draws from the upper left corner (x, y); what lies outside the picture is left out, and what is
/// not printable ASCII stays empty.
void draw_text(Picture& picture, std::uint32_t x, std::uint32_t y, std::uint32_t scale, Rgb colour,
               std::string_view text);

}  // namespace planecast
