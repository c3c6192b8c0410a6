// Parts of a render that show different crops of its film.
#pragma once

#include <vector>

#include "session/part.hpp"

namespace regulus::session {

/// Puts parts with the same samples of different pixels together, which a render of all those pixels would
/// give bit by bit. Precondition: they are of one render (require_same_render, but for the crop), complete,
/// and have the same kinds of sums.
/// @throws regulus::Error (BadFile) that names two parts that overlap or hold other samples, or says that the
/// crops do not fill a rectangle
Part join_windows(std::vector<Part> parts);

}  // namespace regulus::session
