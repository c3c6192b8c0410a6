// Everything of a render that host and kernels share.
#ifndef REGULUS_INTERFACE_WAVEFRONT_H
#define REGULUS_INTERFACE_WAVEFRONT_H

#include "bvh.h"
#include "features.h"
#include "film.h"
#include "frame.h"
#include "path.h"
#include "queues.h"
#include "random.h"
#include "scene.h"
#include "specialization.h"
#include "state.h"
#include "types.h"
#include "wavelengths.h"

#endif
