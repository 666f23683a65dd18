/* All loops, and the table of them: included by each rows_SET.c, after its own put_... . */
#include "core/rows/rows_rules.h"
#include "core/rows/rows_tiles.h"
#include "core/rows/rows_wire.h"

#include "core/rows/rows_normals.h"
#include "core/rows/rows_points.h"
#include "core/rows/rows_smooth.h"

#define DX_ROWS_TABLE(set_name)                                                                    \
    {                                                                                              \
        .name = set_name, .valid = valid_row, .noise = noise_row, .join = join_row,                \
        .join_each = join_each_row, .vote = vote_row, .missing = missing_row,                      \
        .inverse = inverse_row, .residuals = residuals_row, .residuals_each = residuals_each_row,  \
        .bend = bend_row, .code = code_row, .use = use_row, .rank = rank_all,                      \
        .narrow = narrow_all, .spin = spin_row, .emit = emit_row, .keep = keep_row,                \
        .put16 = put16_row, .deltas = deltas_row, .turn = turn_row, .stretch = stretch_row,        \
        .unit = unit_row, .cap = cap_row, .add_cells = add_cells_row,                              \
        .octahedral = octahedral_row, .smoother = DX_SMOOTHER,                                     \
    }
