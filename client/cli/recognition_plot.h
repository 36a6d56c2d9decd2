// What an observation looks like to a database over time, as in the paper's Figs. 13-15. Pure
// function.
#pragma once

#include <motiondb/messages.h>

#include <string>
#include <vector>

namespace motiondb::client {

// The layers that are worth a panel beside the bottom layer: the middle one and an upper one, as
// far as the tree has them and they are not the root alone.
std::vector<int> LayersAbove(int bottom_layer);

// An SVG file that needs no other, with a panel for each answer of Recognize, one below the other:
// the log generation probability of every stored clip at the middle of each window, coloured by
// label, and below them the label that wins the window. All panels have the same axes; values that
// are not finite are left out, and the picture says so. `request` is what was asked of the layer on
// top; where it names no layer, that is the bottom layer of the tree. The same messages make the
// same bytes.
std::string RecognitionPlotSvg(const v1::RecognizeRequest& request,
                               const std::vector<v1::RecognizeResponse>& layers);

}  // namespace motiondb::client
