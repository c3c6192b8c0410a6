// How a render says how far it is.
#pragma once

namespace regulus::cli {

/// `Auto`: a line that is drawn anew on a terminal, otherwise Lines.
enum class ProgressStyle { Auto, Lines, Json, None };

}  // namespace regulus::cli
