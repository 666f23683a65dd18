/* Decoding of quadrature edges. */
#include "drivers/gpio/quadrature.h"

#define ILLEGAL   2
#define MAX_SLACK 1 /* counts: the index's edge may come before or after one of A or B */

/* By the state before and the state after: 00 -> 10 -> 11 -> 01 -> 00 counts up. */
static const int8_t steps[4][4] = {
    /* to  00       01       10       11 */
    {0, -1, 1, ILLEGAL},
    {1, 0, ILLEGAL, -1},
    {-1, ILLEGAL, 0, 1},
    {ILLEGAL, 1, -1, 0},
};

void dx_quadrature_init(struct dx_quadrature *q, uint32_t counts_per_turn, bool has_index, bool a,
                        bool b)
{
    *q = (struct dx_quadrature){
        .counts_per_turn = counts_per_turn,
        .has_index = has_index,
        .is_uncertain = has_index,
        .state = (uint8_t)(a << 1 | b),
    };
}

static unsigned doubt_it(struct dx_quadrature *q)
{
    q->z_dir = 0;
    q->is_uncertain = true;
    q->n_doubts++;
    return DX_QUADRATURE_DOUBT;
}

/* By how many counts it is off a whole turn, the nearest one. */
static int64_t off_turn(const struct dx_quadrature *q, int64_t count)
{
    int64_t turn = q->counts_per_turn, rest = count % turn;

    rest += rest < 0 ? turn : 0;
    return rest > turn / 2 ? rest - turn : rest;
}

static unsigned pass_index(struct dx_quadrature *q)
{
    int64_t error = off_turn(q, q->z_count);
    bool is_right = q->is_indexed && error >= -MAX_SLACK && error <= MAX_SLACK;

    if (!is_right) {
        q->count -= error;
        q->n_mismatch += q->is_indexed;
        q->last_mismatch = q->is_indexed ? error : 0;
    }
    q->is_indexed = true;
    q->is_uncertain = false;
    q->n_index++;
    return DX_QUADRATURE_INDEX | (is_right ? 0 : DX_QUADRATURE_REZEROED);
}

static unsigned count_it(struct dx_quadrature *q, int step)
{
    bool is_index = q->z_dir == step;

    q->count += step;
    q->dir = (int8_t)step;
    q->z_dir = 0;
    return DX_QUADRATURE_MOVED | (is_index ? pass_index(q) : 0);
}

static void index_edge(struct dx_quadrature *q, bool rising)
{
    q->z_dir = (int8_t)(rising ? q->dir == 1 : -(q->dir == -1));
    q->z_count = q->count;
}

unsigned dx_quadrature_edge(struct dx_quadrature *q, enum dx_quadrature_line line, bool rising,
                            bool doubt)
{
    unsigned result = doubt ? doubt_it(q) : 0;
    uint8_t state = q->state, bit;
    int step;

    if (line == DX_QUADRATURE_Z) {
        index_edge(q, rising);
        return result;
    }
    bit = line == DX_QUADRATURE_A ? 2 : 1;
    q->state = (uint8_t)(rising ? state | bit : state & ~bit);
    step = steps[state][q->state];
    if (step == 0) /* the edge back was lost */
        return result | (doubt ? 0 : doubt_it(q));
    return result | count_it(q, step);
}

unsigned dx_quadrature_levels(struct dx_quadrature *q, bool a, bool b)
{
    uint8_t state = q->state;
    int step;

    q->state = (uint8_t)(a << 1 | b);
    step = steps[state][q->state];
    if (step == ILLEGAL) {
        q->count += 2 * q->dir; /* keeps the count in step with the lines */
        return doubt_it(q) | DX_QUADRATURE_MOVED;
    }
    return step ? count_it(q, step) : 0;
}

unsigned dx_quadrature_both(struct dx_quadrature *q, bool a, bool b)
{
    uint8_t state = q->state;
    unsigned result;

    q->state = (uint8_t)(a << 1 | b);
    result = doubt_it(q);
    if (steps[state][q->state] == ILLEGAL) {
        q->count += 2 * q->dir;
        result |= DX_QUADRATURE_MOVED;
    } else if (steps[state][q->state]) {
        result |= count_it(q, steps[state][q->state]);
    }
    return result;
}
