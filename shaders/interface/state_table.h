// Every array of the wavefront, one row each. No include guard: a file that includes this says what a row becomes,
//   STATE(name, element, times, per, when)
// `times` elements of type `element` for each of `per` (PER_*), held where `when` is STATE_ALWAYS or the plan's state has
// one of its bits. Members of the frame, buffers, their sizes and the bytes of a path all follow from here
// (host/render/state.hpp).
// clang-format off

// ---- paths, by slot
STATE(paths,                   Path,                1,                    PER_PATH,           STATE_ALWAYS)
STATE(hits,                    Hit,                 1,                    PER_PATH,           STATE_ALWAYS)
STATE(radiance,                vec3,                1,                    PER_PATH,           STATE_ALWAYS)
// The vertex before the ray, as light sampling sees it.
STATE(light_receivers,         LightReceiver,       1,                    PER_PATH,           STATE_RECEIVERS)
STATE(path_histories,          PathHistory,         1,                    PER_PATH,           STATE_HISTORIES)
// lib/footprint.glsl
STATE(path_footprints,         vec3,                1,                    PER_PATH,           STATE_FOOTPRINTS | STATE_SIGMA)
// Trail of the path on arrival, and of light paths the group (interface/path.h).
STATE(path_trails,             uint,                1,                    PER_PATH,           STATE_LAYERS)
STATE(path_media,              PathMedia,           1,                    PER_PATH,           STATE_MEDIA)
// Accumulators (A, B) for a camera that sees the vertex sharply (lib/mis.glsl).
STATE(light_path_sharp,        vec2,                1,                    PER_PATH,           STATE_SHARP)
// The first unit of its merge, where the merges of a bounce are counted.
STATE(merge_starts,            uint,                1,                    PER_PATH,           STATE_MERGES)

// ---- queues
STATE(queue_heads,             QueueHead,           QUEUES_PER_BOUNCE,    PER_BOUNCE,         STATE_ALWAYS)
// Two lists of path slots, used in turns by bounce parity.
STATE(ray_queues,              uint,                2,                    PER_PATH,           STATE_ALWAYS)
STATE(bounce_queues,           uint,                MATERIAL_CLASS_COUNT, PER_PATH,           STATE_ALWAYS)
STATE(escaped,                 uint,                1,                    PER_PATH,           STATE_ESCAPES)
STATE(candidates,              VisibilityCandidate, 1,                    PER_CANDIDATE,      STATE_CANDIDATES)
STATE(candidate_media,         PathMedia,           1,                    PER_CANDIDATE,      STATE_MEDIA)
STATE(candidate_strategies,    StrategyCandidate,   1,                    PER_CANDIDATE,      STATE_STRATEGIES)
// Trail of the whole path, and its light's group.
STATE(candidate_trails,        uint,                1,                    PER_CANDIDATE,      STATE_LAYERS)
STATE(splats,                  SplatCandidate,      1,                    PER_SPLAT,          STATE_ALWAYS)
STATE(splat_media,             PathMedia,           1,                    PER_SPLAT,          STATE_MEDIA)
STATE(splat_strategies,        StrategyCandidate,   1,                    PER_SPLAT,          STATE_STRATEGIES)
STATE(splat_trails,            uint,                1,                    PER_SPLAT,          STATE_LAYERS)
STATE(pairs,                   ConnectionPair,      MATERIAL_CLASS_COUNT, PER_PAIR,           STATE_ALWAYS)

// ---- vertices that connections and merges join
STATE(camera_vertices,         CameraVertex,        1,                    PER_CAMERA_VERTEX,  STATE_ALWAYS)
STATE(camera_vertex_histories, PathHistory,         1,                    PER_CAMERA_VERTEX,  STATE_HISTORIES)
// On the side that the path arrived from.
STATE(camera_vertex_media,     MediaSet,            1,                    PER_CAMERA_VERTEX,  STATE_MEDIA)
STATE(camera_vertex_trails,    uint,                1,                    PER_CAMERA_VERTEX,  STATE_LAYERS)
STATE(light_heads,             LightPathHead,       1,                    PER_LIGHT_PATH,     STATE_ALWAYS)
STATE(light_vertices,          LightVertex,         1,                    PER_LIGHT_VERTEX,   STATE_ALWAYS)
STATE(light_vertex_histories,  PathHistory,         1,                    PER_LIGHT_VERTEX,   STATE_HISTORIES)
STATE(light_vertex_trails,     uint,                1,                    PER_LIGHT_VERTEX,   STATE_LAYERS)
STATE(light_vertex_media,      MediaSet,            1,                    PER_LIGHT_VERTEX,   STATE_MEDIA)
STATE(light_vertex_sharp,      vec2,                1,                    PER_LIGHT_VERTEX,   STATE_SHARP)
// LIGHT_COUNT_* words; may exceed light_vertex_capacity, what does not fit is not stored.
STATE(light_vertex_count,      uint,                LIGHT_COUNT_WORDS,    PER_RENDER,         STATE_ALWAYS)
// Exclusive scan of LightPathHead.count.
STATE(light_path_ends,         uint,                1,                    PER_LIGHT_PATH_SUM, STATE_CACHE)

// ---- the merge grid
// First entry of each cell, and one past the last cell.
STATE(grid_cells,              uint,                1,                    PER_CELL_SUM,       STATE_MERGES)
// Place of each light vertex in its cell.
STATE(grid_ranks,              uint,                1,                    PER_LIGHT_VERTEX,   STATE_MERGES)
STATE(grid_entries,            GridEntry,           1,                    PER_LIGHT_VERTEX,   STATE_MERGES)

// ---- pixels
STATE(film,                    uint,                FILM_WORDS_PER_PIXEL, PER_PIXEL,          STATE_ALWAYS)
// As `film`, sums of technique `splat`.
STATE(splat_film,              uint,                FILM_WORDS_PER_PIXEL, PER_PIXEL,          STATE_SPLATS)
// `film` and `splat_film` together, as they were after the last whole sample.
STATE(film_earlier,            uint,                FILM_WORDS_PER_PIXEL, PER_PIXEL,          STATE_SQUARES)
// Sums of the squares of whole samples.
STATE(film_squares,            uint,                FILM_WORDS_PER_PIXEL, PER_PIXEL,          STATE_SQUARES)
STATE(aovs,                    AovPixel,            1,                    PER_PIXEL,          STATE_SURFACES)
// Of each of the AOV_RAYS rays: instance and material that it meets, or INVALID_INDEX.
STATE(aov_ids,                 uint,                2 * AOV_RAYS,         PER_PIXEL,          STATE_IDS)
// Of each strategy two films, weighted and not (lib/strategies.glsl).
STATE(strategy_film,           uint,                FILM_WORDS_PER_PIXEL, PER_STRATEGY_PIXEL, STATE_STRATEGIES)
// The films of all layers, then those of their splats.
STATE(layer_film,              uint,                FILM_WORDS_PER_PIXEL, PER_LAYER_PIXEL,    STATE_LAYERS)
// The group of each light.
STATE(light_groups,            uint,                1,                    PER_LIGHT,          STATE_LAYERS)
// The number of a strategy, by the path's edges, s, and whether it is a merge.
STATE(strategy_layers,         uint,                1,                    PER_STRATEGY_PLACE, STATE_STRATEGIES)
// 64 bits each, see COUNTER_*.
STATE(counters,                uint,                2 * COUNTER_COUNT,    PER_RENDER,         STATE_ALWAYS)
// clang-format on
