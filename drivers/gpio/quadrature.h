/*
 * A quadrature encoder's count from the edges of its two lines, four counts a cycle, and its index
 * line: where a turn begins, and whether the counts of a turn were all there. Fed with events;
 * knows no clock. Owned by its encoder.
 */
#ifndef DX_QUADRATURE_H
#define DX_QUADRATURE_H

#include <stdbool.h>
#include <stdint.h>

enum dx_quadrature_line { DX_QUADRATURE_A = 0, DX_QUADRATURE_B = 1, DX_QUADRATURE_Z = 2 };

/* What an edge has meant; bits. */
enum dx_quadrature_result {
    DX_QUADRATURE_MOVED = 1, /* the count has changed, by one */
    DX_QUADRATURE_DOUBT = 2, /* edges are missing: levels are to be read and told */
    DX_QUADRATURE_INDEX = 4, /* the index was passed: the count is right from here on */
    DX_QUADRATURE_REZEROED =
        8, /* with the index: the count was wrong, or had no zero, and has jumped */
};

struct dx_quadrature {
    uint32_t counts_per_turn; /* of the encoder, four a cycle */
    bool has_index;           /* there is an index line */
    int64_t count;            /* whole turns at the index, once it was passed */
    bool is_uncertain; /* counts may be missing since the last index, or it was never passed */
    bool is_indexed;   /* it was passed once */
    uint8_t state;     /* A << 1 | B */
    int8_t dir;        /* of the last count: 1, -1; 0: none yet */
    int8_t z_dir; /* not 0: the index has told of a turn that way, if the next count goes on so */
    int64_t z_count; /* then */

    uint64_t n_doubts;     /* edges that cannot follow the one before, gaps, overflows */
    uint64_t n_index;      /* times that the index was passed */
    uint64_t n_mismatch;   /* of them, with a wrong count */
    int64_t last_mismatch; /* by how many counts */
};

/* Levels as they are now. Without an index line the count is taken as certain from here on. */
void dx_quadrature_init(struct dx_quadrature *q, uint32_t counts_per_turn, bool has_index, bool a,
                        bool b);

/*
 * One edge; bits of enum dx_quadrature_result. `doubt`: edges before it may be missing (a gap in
 * the numbers, an overflow, an order that cannot be known).
 *
 * A turn begins where the index rises while counting up: the same place where it falls while
 * counting down. Which way it goes there is certain with the next count only, and that is when the
 * index is passed. An error of one count is the index's edge beside one of A or B, and changes
 * nothing.
 */
unsigned dx_quadrature_edge(struct dx_quadrature *q, enum dx_quadrature_line line, bool rising,
                            bool doubt);

/* The levels of A and B, read after a doubt when no event waits: the count follows as far as they
 * tell. Bits. */
unsigned dx_quadrature_levels(struct dx_quadrature *q, bool a, bool b);

/* Two lines changed at one time and no one knows in which order: taken as two counts on in the
 * direction of the last one. Bits. */
unsigned dx_quadrature_both(struct dx_quadrature *q, bool a, bool b);

#endif
