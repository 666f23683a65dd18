/* All loops, and the table of them: included by each rows_SET.c, after its own ones. */
#include "core/rows/rows_rules.h"

#define TOO_NEAR INFINITY /* nothing is sure beside it */

/*
 * An f32 is off by 2^-24 of itself. An inverse range takes one rounding, what a corner and its
 * opposite make of a bend two more, the difference to what is beyond them one, that of two bends
 * and of the bias two, the bias itself seven: all that together is below 16 of them. The integers
 * are cut to whole numbers: eight inverse ranges with weights of at most 1 and the noise, below 16
 * units. The noise of q is sigma8 q / r, with q / r = q^2 / 2^40.
 */
#define REAL        float
#define RANGE       uint16_t
#define NAME(x)     narrow_##x
#define ABS(x)      fabsf(x)
#define INVERSE(r)  (0x1p40f / (r))
#define SLOPE(q, r) ((q) * (q)*0x1p-47f)
#define ROUNDING    0x1p-20f
#define CUTS        16.0f
#define TELL        tell_f32
#include "core/rows/rows_bends.h"

static struct dx_row_preference tell_f64(const double *more, const double *margin)
{
    uint32_t prefers[CELLS], sure[CELLS];

    for (uint32_t j = 0; j < CELLS; j++) {
        prefers[j] = more[j] > 0 ? UINT32_MAX : 0;
        sure[j] = fabs(more[j]) > margin[j] ? UINT32_MAX : 0; /* not where it is no number */
    }
    return (struct dx_row_preference){(uint64_t)pack32(prefers, CELLS),
                                      (uint64_t)~pack32(sure, CELLS)};
}

/* f64 holds the integers' inverse ranges themselves: only the noise is cut. */
#define REAL        double
#define RANGE       uint32_t
#define NAME(x)     wide_##x
#define ABS(x)      fabs(x)
#define INVERSE(r)  floor(0x1p40 / (r))
#define SLOPE(q, r) ((q) / (r)*0x1p-7)
#define ROUNDING    0x1p-48
#define CUTS        1.0
#define TELL        tell_f64
#include "core/rows/rows_bends.h"

#include "core/rows/rows_words.h"

#include "core/rows/rows_filters.h"
#include "core/rows/rows_fit.h"
#include "core/rows/rows_lod.h"
#include "core/rows/rows_wire.h"

#include "core/rows/rows_normals.h"
#include "core/rows/rows_points.h"
#include "core/rows/rows_smooth.h"

#define BENDS(kind)                                                                                \
    {                                                                                              \
        .inverse = kind##_inverse, .bend = kind##_bend, .bend_each = kind##_bend_each,             \
    }

#define RULES                                                                                      \
    {                                                                                              \
        .join_there = join_there_words, .attached = attached_words,                                \
        .well_joined = well_joined_words, .keep_alive = keep_alive_words,                          \
        .triangles = triangles_words, .outcomes = outcomes_words, .corners = corners_words,        \
    }

#define FILTERS                                                                                    \
    {                                                                                              \
        .join_mean = join_mean_row, .tell_mean = tell_mean_row, .median3 = median3_row,            \
        .may_have_moved = may_have_moved_row,                                                      \
    }

#define DX_ROWS_TABLE(set_name)                                                                    \
    {                                                                                              \
        .name = (set_name), .valid = valid_row, .valid_wide = valid_wide_row,                      \
        .valid_rows = valid_rows, .join = join_rows, .join_wide = join_wide_row,                   \
        .join_wide_each = join_wide_each_row, .narrow = BENDS(narrow), .wide = BENDS(wide),        \
        .rules = RULES, .code = code_row, .bits = bits_row, .some = some_row, .count = count_rows, \
        .rank = rank_row, .digest = digest_rows, .digest_words = digest_words_rows,                \
        .spin = spin_row, .emit = emit_row, .keep = keep_row, .keep16 = keep16_row,                \
        .widen = widen_rows, .pack_codes = pack_codes_rows,                                        \
        .count_triangles = count_triangles_rows, .deltas = deltas_row, .turn = turn_row,           \
        .stretch = stretch_row, .unit = unit_row, .cap = cap_row, .add_cells = add_cells_row,      \
        .octahedral = octahedral_row, .units = units_row, .on_beams = on_beams_row,                \
        .filters = FILTERS, .errors = errors_row, .raise = raise_row, .smoother = DX_SMOOTHER,     \
    }
