// The exception type that users of the library see. Thrown where the problem is known.
#pragma once

#include "regulus/error.hpp"
