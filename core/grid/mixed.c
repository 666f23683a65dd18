/* Mixed pixels by the votes of a sample's row and column. */
#include "core/grid/mixed.h"

/* Rows from the first that is read to the last have joined edges on both sides only inside; outside
 * of it the area ends, and no outcome of the tile asks. */
void dx_mixed_find(struct dx_area *a, const struct dx_gates *gates)
{
    const struct dx_row_rules *rules = &gates->rows->rules;

    if (gates->mixed == DX_MIXED_OFF)
        a->alive = a->valid;
    else
        rules->attached(&a->alive, &a->valid, a->joined);
    if (gates->mixed == DX_MIXED_STRICT)
        rules->well_joined(&a->alive, a->joined);
    dx_words_put(&a->alive, a->first, dx_words_at(&a->valid, a->first));
    dx_words_put(&a->alive, a->end - 1, dx_words_at(&a->valid, a->end - 1));
    rules->keep_alive(a->edge, a->joined, &a->alive);
}
