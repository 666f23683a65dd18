/*
 * Every instruction set gives what the generic loops give (docs/terrain.md: T6): whole tiles of
 * random frames by all rules, and the loops over tiles and points on random ones.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/bytes.h"
#include "core/grid/octahedral.h"
#include "rounds.h"
#include "terrain_rig.h"

/* The sets beside the generic one that this machine has. */
static int find_sets(const struct dx_rows *sets[DX_N_SIMD])
{
    int n = 0;

    for (enum dx_simd k = DX_SIMD_GENERIC + 1; k < DX_N_SIMD; k++)
        if (dx_rows_get(k))
            sets[n++] = dx_rows_get(k);
    return n;
}

/* What was published too: smoothed ranges are by loops over rows. */
static void assert_same_tiles(const struct dx_terrain *x, const struct dx_terrain *y)
{
    const struct dx_plane *p = dx_terrain_published(x), *q = dx_terrain_published(y);
    struct dx_tile *a = calloc(1, sizeof(*a)), *b = calloc(1, sizeof(*b));

    assert_true(a && b);
    assert_memory_equal(p->range, q->range, dx_plane_n_dexels(p) * p->range_bytes);
    for (uint32_t k = 0; k < dx_tiling_n_tiles(dx_terrain_tiling(x)); k++) {
        assert_int_equal(dx_terrain_tile(x, k, a), dx_terrain_tile(y, k, b));
        assert_memory_equal(a->code, b->code, sizeof(a->code));
        assert_memory_equal(a->strut, b->strut, sizeof(a->strut));
    }
    free(a);
    free(b);
}

/* The ends of what 16 bits and the fixed point hold, equal ranges, ties. */
static void extreme_frame(struct dx_plane *p, struct dx_rng *rng)
{
    static const uint32_t ends[] = {0, 1, 15, 16, 17, 32767, 32768, 65534, 65535, 65535};
    const uint32_t step = 1 + dx_rng_below(rng, 3);

    for (size_t k = 0; k < dx_plane_n_dexels(p); k++)
        dx_plane_set_range(p, k,
                           dx_rng_below(rng, 4) ? 16 + step * dx_rng_below(rng, 4)
                                                : ends[dx_rng_below(rng, 10)]);
}

/* Returns the number of cells that were compared. */
static size_t compare_frame(struct dx_rng *rng, const struct variant *v)
{
    const uint32_t height = 2 + dx_rng_below(rng, 140), width = 2 + dx_rng_below(rng, 140);
    struct dx_geometry *g =
        any_geometry(rng, height, width, (uint8_t)(dx_rng_below(rng, 8) ? 2 : 4));
    struct dx_terrain_params q;
    struct dx_terrain *want;
    struct dx_plane p;
    size_t n = 0;

    assert_int_equal(dx_plane_init(&p, g->height, g->width, g->range_bytes, 0), 0);
    (dx_rng_below(rng, 4) ? any_frame : extreme_frame)(&p, rng);
    any_rules(&q, v, rng);
    q.smooth = dx_rng_below(rng, 6) == 0;
    q.simd = DX_SIMD_GENERIC;
    want = meshed(g, &q, &p, NULL);
    for (q.simd = DX_SIMD_GENERIC + 1; q.simd < DX_N_SIMD; q.simd++) {
        struct dx_terrain *got;

        if (!dx_rows_get(q.simd))
            continue;
        got = meshed(g, &q, &p, NULL);
        assert_same_tiles(got, want);
        n += dx_plane_n_dexels(&p);
        dx_terrain_free(got);
    }
    dx_terrain_free(want);
    dx_plane_fini(&p);
    dx_geometry_unref(g);
    return n;
}

static void every_set_decides_alike(void **state)
{
    const size_t n_cells = long_run() ? 100000000 : ROUNDS(2000000);
    const struct dx_rows *sets[DX_N_SIMD];
    struct dx_rng rng = dx_rng_init(6, 0);
    size_t n = 0;

    (void)state;
    if (find_sets(sets) == 0)
        skip(); /* nothing to compare: the generic set alone */
    for (uint32_t k = 0; n < n_cells; k++)
        n += compare_frame(&rng, &variants[k % (uint32_t)N_VARIANTS]);
}

/* ---- the loops over tiles -------------------------------------------------------------------- */

static void any_codes(struct dx_tile *tile, struct dx_rng *rng)
{
    const uint32_t holes = dx_rng_below(rng, 3) * dx_rng_below(rng, 40);

    for (uint32_t k = 0; k < sizeof(tile->code); k++)
        tile->code[k] = dx_rng_below(rng, 100) < holes ? (uint8_t)dx_rng_below(rng, 7)
                                                       : (uint8_t)(3 + 3 * dx_rng_below(rng, 2));
}

/* The corners that outcomes use: rows and columns from the cell on. */
static void mark_used(dx_bits used[DX_BLOCK], const struct dx_tile *tile)
{
    static const char *const corners[] = {"", "abc", "acd", "abcd", "abd", "bcd", "abcd"};

    memset(used, 0, DX_BLOCK * sizeof(*used));
    for (uint32_t k = 0; k < sizeof(tile->code); k++)
        for (const char *c = corners[tile->code[k]]; *c; c++)
            used[k / 64 + 1 + (*c == 'c' || *c == 'd')] |=
                (dx_bits)1 << (k % 64 + 1 + (*c == 'b' || *c == 'c'));
}

struct outcome {
    dx_bits used[DX_BLOCK];
    uint64_t bit[DX_TILE_CELLS][3], digest[DX_ROWS_LANES];
    uint8_t code[DX_TILE_CELLS * DX_TILE_CELLS];
    uint8_t packed[3 * DX_TILE_CELLS * DX_TILE_CELLS / 8 + 1];
    uint16_t first[DX_BLOCK + 1], rank[DX_BLOCK_DEXELS];
    uint16_t kept16[DX_BLOCK_DEXELS + DX_ROWS_SLACK];
    uint32_t kept[DX_BLOCK_DEXELS + DX_ROWS_SLACK], wide[DX_BLOCK_DEXELS + DX_ROWS_SLACK];
    uint16_t index[3 * DX_TILE_MAX_TRIANGLES + DX_ROWS_SLACK];
    float xyz[3 * DX_TILE_MAX_VERTICES + DX_ROWS_SLACK];
    uint32_t n_kept, n_kept16, n_index, n_floats, n_triangles;
};

static void run_cells(struct outcome *o, const struct dx_rows *rows, const struct dx_tile *tile,
                      bool flip)
{
    uint16_t *index = o->index;

    for (uint32_t i = 0; i < DX_TILE_CELLS; i++) {
        const struct dx_row_ranks ranks = {o->used[i + 1], o->used[i + 2], o->first[i + 1],
                                           o->first[i + 2]};

        rows->bits(o->bit[i], tile->code + i * DX_TILE_CELLS);
        rows->code(o->code + i * DX_TILE_CELLS, o->bit[i]);
        index = rows->emit(index, tile->code + i * DX_TILE_CELLS, &ranks, flip);
    }
    o->n_index = (uint32_t)(index - o->index);
    rows->pack_codes(o->packed, tile->code, DX_TILE_CELLS);
    o->n_triangles = rows->count_triangles(tile->code, DX_TILE_CELLS);
}

static void run_loops(struct outcome *o, const struct dx_rows *rows, const struct dx_tile *tile,
                      const struct dx_row_spin *spin, bool flip)
{
    uint16_t *kept16 = o->kept16, narrow[DX_BLOCK_DEXELS + DX_ROWS_SLACK] = {0};
    uint32_t *kept = o->kept;
    float *xyz = o->xyz;

    memset(o, 0, sizeof(*o));
    mark_used(o->used, tile);
    rows->count(o->first, o->used, DX_BLOCK);
    run_cells(o, rows, tile, flip);
    for (uint32_t i = 0; i < DX_BLOCK; i++) {
        const uint32_t *range = tile->range + i * DX_BLOCK;
        uint16_t rank[DX_ROWS_N], low[DX_ROWS_N];
        const uint16_t *const row = low;

        rows->rank(rank, o->used[i], o->first[i]);
        for (uint32_t j = 0; j < DX_BLOCK; j++)
            o->rank[i * DX_BLOCK + j] = dx_bits_at(o->used[i], j) ? rank[j] : 0;
        for (uint32_t j = 0; j < DX_ROWS_N; j++)
            low[j] = (uint16_t)range[j];
        rows->digest(o->digest, &row, o->used + i, 1);
        xyz = rows->spin(xyz, spin, range, o->used[i]);
        kept = rows->keep(kept, range, o->used[i]);
        kept16 = rows->keep16(kept16, range, o->used[i]);
    }
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        narrow[k] = (uint16_t)tile->range[k];
    rows->widen(o->wide, narrow, DX_BLOCK, DX_BLOCK);
    o->n_floats = (uint32_t)(xyz - o->xyz);
    o->n_kept = (uint32_t)(kept - o->kept);
    o->n_kept16 = (uint32_t)(kept16 - o->kept16);
}

/* What the loops promise, told in one line each. */
static void check_generic(const struct outcome *o, const struct dx_tile *tile)
{
    uint32_t n = 0, n_triangles = 0;

    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        if (!dx_bits_at(o->used[k / DX_BLOCK], k % DX_BLOCK))
            continue;
        assert_int_equal(o->rank[k], n);
        assert_int_equal(o->kept[n], tile->range[k]);
        assert_int_equal(o->kept16[n], (uint16_t)tile->range[k]);
        n++;
    }
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        assert_int_equal(o->wide[k], (uint16_t)tile->range[k]);
    for (uint32_t k = 0; k < sizeof(tile->code); k++)
        n_triangles += tile->code[k] == 0 ? 0 : tile->code[k] == 3 || tile->code[k] == 6 ? 2 : 1;
    for (uint32_t k = 0; k < 3 * sizeof(tile->code); k++)
        assert_int_equal(o->packed[k / 8] >> k % 8 & 1, tile->code[k / 3] >> k % 3 & 1);
    assert_memory_equal(o->code, tile->code, sizeof(tile->code));
    assert_int_equal(o->first[DX_BLOCK], n);
    assert_int_equal(o->n_kept, n);
    assert_int_equal(o->n_kept16, n);
    assert_int_equal(o->n_floats, 3 * n);
    assert_int_equal(o->n_index, 3 * n_triangles);
    assert_int_equal(o->n_triangles, n_triangles);
}

static void assert_same_outcome(const struct outcome *got, const struct outcome *want)
{
    assert_int_equal(got->n_floats, want->n_floats);
    assert_int_equal(got->n_index, want->n_index);
    assert_int_equal(got->n_triangles, want->n_triangles);
    assert_memory_equal(got->packed, want->packed, sizeof(want->packed));
    assert_memory_equal(got->bit, want->bit, sizeof(want->bit));
    assert_memory_equal(got->code, want->code, sizeof(want->code));
    assert_memory_equal(got->digest, want->digest, sizeof(want->digest));
    assert_memory_equal(got->first, want->first, sizeof(want->first));
    assert_memory_equal(got->rank, want->rank, sizeof(want->rank));
    assert_memory_equal(got->index, want->index, want->n_index * sizeof(*want->index));
    assert_memory_equal(got->xyz, want->xyz, want->n_floats * sizeof(*want->xyz));
    assert_memory_equal(got->wide, want->wide, sizeof(want->wide));
    assert_int_equal(got->n_kept, want->n_kept);
    assert_memory_equal(got->kept, want->kept, want->n_kept * sizeof(*want->kept));
    assert_int_equal(got->n_kept16, want->n_kept16);
    assert_memory_equal(got->kept16, want->kept16, want->n_kept16 * sizeof(*want->kept16));
}

static void every_set_builds_alike(void **state)
{
    const struct dx_rows *sets[DX_N_SIMD];
    const float row[6] = {0.7f, 0.1f, -0.5f, 0.01f, -0.02f, 0.3f};
    struct outcome *want = malloc(sizeof(*want)), *got = malloc(sizeof(*got));
    struct dx_tile *tile = calloc(1, sizeof(*tile));
    struct dx_rng rng = dx_rng_init(6, 1);
    const int n = find_sets(sets);

    (void)state;
    assert_true(want && got && tile);
    for (int k = 0; k < ROUNDS(200); k++) {
        struct dx_row_spin spin = {.row = row, .unit_m = 0.001f};
        const bool flip = dx_rng_below(&rng, 2);

        any_codes(tile, &rng);
        for (uint32_t j = 0; j < DX_BLOCK_DEXELS; j++)
            tile->range[j] = (uint32_t)(dx_rng_u64(&rng) >> (k % 2 ? 32 : 48));
        for (uint32_t j = 0; j < DX_ROWS_N; j++) {
            spin.c[j] = (float)dx_rng_unit(&rng);
            spin.s[j] = (float)dx_rng_unit(&rng);
        }
        run_loops(want, dx_rows_get(DX_SIMD_GENERIC), tile, &spin, flip);
        check_generic(want, tile);
        for (int s = 0; s < n; s++) {
            run_loops(got, sets[s], tile, &spin, flip);
            assert_same_outcome(got, want);
        }
    }
    free(want);
    free(got);
    free(tile);
}

/* ---- the loops over points ------------------------------------------------------------------- */

struct measured {
    struct dx_row_points turned, stretched, unit;
    struct dx_row_joined cap;
};

struct places {
    float row[6], r[DX_ROWS_N];
    struct dx_row_turn turn;
    struct dx_row_points beam;
};

static void any_places(struct places *x, struct dx_rng *rng)
{
    for (int k = 0; k < 6; k++)
        x->row[k] = (float)(dx_rng_unit(rng) - 0.5);
    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        x->r[j] = (float)(1 + 0.01 * dx_rng_unit(rng));
        x->turn.c[j] = (float)(dx_rng_unit(rng) - 0.5);
        x->turn.s[j] = (float)(dx_rng_unit(rng) - 0.5);
    }
    for (uint32_t j = 0; j < DX_ROWS_N + 8; j++) {
        x->beam.x[j] = (float)(dx_rng_unit(rng) - 0.5);
        x->beam.y[j] = (float)(dx_rng_unit(rng) - 0.5);
        x->beam.z[j] = (float)(dx_rng_unit(rng) + 0.5);
    }
}

/* With a margin that makes some pairs unsure. */
static void measure(struct measured *m, const struct dx_rows *rows, const struct places *x)
{
    const struct dx_row_points *p = &m->turned;
    const struct dx_row_span span = {
        .x = {p->x, p->x + 1}, .y = {p->y, p->y + 1}, .z = {p->z, p->z + 1}};

    memset(m, 0, sizeof(*m));
    rows->turn(&m->turned, x->row, &x->turn, x->r);
    rows->stretch(&m->stretched, &x->beam, x->r);
    m->unit = x->beam;
    rows->unit(&m->unit);
    m->cap = rows->cap(&span, 0.1f, 0.02f);
}

/* What the loops promise of a row. */
static void check_measured(const struct measured *m)
{
    const struct dx_row_points *u = &m->unit, *t = &m->turned;

    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        const double l2 = (double)u->x[j] * (double)u->x[j] + (double)u->y[j] * (double)u->y[j] +
                          (double)u->z[j] * (double)u->z[j];

        assert_true(l2 > 1 - 0x1p-19 && l2 < 1 + 0x1p-19);
    }
    for (uint32_t j = 0; j + 1 < DX_ROWS_N; j++) {
        const double a = (double)(t->x[j] - t->x[j + 1]), b = (double)(t->y[j] - t->y[j + 1]);
        const double c = (double)(t->z[j] - t->z[j + 1]), more = a * a + b * b + c * c - 0.1;

        assert_int_equal(dx_bits_at(m->cap.unsure, j), fabs(more) <= 0.02);
        assert_true(fabs(more) <= 0.02 || dx_bits_at(m->cap.joined, j) == (more < 0));
    }
}

static void every_set_measures_alike(void **state)
{
    const struct dx_rows *sets[DX_N_SIMD];
    struct dx_rng rng = dx_rng_init(6, 2);
    const int n = find_sets(sets);
    uint32_t n_within = 0, n_unsure = 0;

    (void)state;
    for (int k = 0; k < ROUNDS(500); k++) {
        struct measured want, got;
        struct places x;

        any_places(&x, &rng);
        measure(&want, dx_rows_get(DX_SIMD_GENERIC), &x);
        check_measured(&want);
        n_within += dx_bits_count(want.cap.joined);
        n_unsure += dx_bits_count(want.cap.unsure);
        for (int s = 0; s < n; s++) {
            measure(&got, sets[s], &x);
            assert_memory_equal(&got, &want, sizeof(want));
        }
    }
    assert_true(n_within > ROUNDS(1000) && n_unsure > ROUNDS(1000));
}

static void lengths_that_f32_cannot_square_are_told(void **state)
{
    static const float lengths[] = {0, 1e-25f, 1e25f};

    (void)state;
    for (enum dx_simd k = DX_SIMD_GENERIC; k < DX_N_SIMD; k++)
        for (int l = 0; dx_rows_get(k) && l < 3; l++) {
            struct dx_row_points p = {.x = {1, lengths[l], 1}};

            dx_rows_get(k)->unit(&p);
            assert_true(p.x[0] == 1 && p.x[2] == 1);
            assert_true(isnan(p.x[1]));
        }
}

/* ---- the loops for normals ------------------------------------------------------------------- */

struct normals {
    struct dx_row_points top, bottom;
    int8_t bytes[2][2 * DX_ROWS_N];
};

/* Sums of all lengths, whole numbers and halves among them, and what has no direction. */
static void any_sums(struct dx_row_points *p, struct dx_rng *rng)
{
    static const float odd[] = {0, -0.0f, 1, -1, 0.5f, 1e38f, 1e-44f, INFINITY, NAN};
    float *const lanes[3] = {p->x, p->y, p->z};

    for (uint32_t j = 0; j < DX_ROWS_N + 8; j++)
        for (int k = 0; k < 3; k++)
            lanes[k][j] = dx_rng_below(rng, 5) ? (float)(2 * dx_rng_unit(rng) - 1)
                                               : odd[dx_rng_below(rng, 9)];
}

/* To the bit; of what is no number, that it is none. */
static void assert_same_sums(const struct dx_row_points *a, const struct dx_row_points *b)
{
    const float *const x[3] = {a->x, a->y, a->z}, *const y[3] = {b->x, b->y, b->z};

    for (uint32_t j = 0; j < DX_ROWS_N; j++)
        for (int k = 0; k < 3; k++)
            assert_true(dx_f32_bits(x[k][j]) == dx_f32_bits(y[k][j]) ||
                        (isnan(x[k][j]) && isnan(y[k][j])));
}

static void find_normals(struct normals *n, const struct dx_rows *rows,
                         const struct dx_row_points point[2], const struct dx_row_points *sums,
                         const uint8_t *code)
{
    dx_bits used = 0;

    memset(n, 0, sizeof(*n));
    for (uint32_t j = 0; j < DX_ROWS_N; j++)
        used |= (dx_bits)(code[j] != 2) << j;
    rows->add_cells(&n->top, &n->bottom, &point[0], &point[1], code);
    for (int flip = 0; flip < 2; flip++)
        rows->octahedral(n->bytes[flip], sums, used, flip);
}

/* Lane by lane as octahedral.h has it. */
static void check_octahedral(const struct normals *n, const struct dx_row_points *sums,
                             const uint8_t *code)
{
    for (uint32_t j = 0; j < DX_ROWS_N; j++)
        for (int flip = 0; flip < 2; flip++) {
            const float sign = flip ? -1 : 1;
            const float sum[3] = {sign * sums->x[j], sign * sums->y[j], sign * sums->z[j]};
            int8_t want[2] = {0, 0};

            if (code[j] != 2)
                dx_octahedral_encode(want, sum);
            assert_memory_equal(n->bytes[flip] + 2 * j, want, 2);
        }
}

static void every_set_finds_the_same_normals(void **state)
{
    const struct dx_rows *sets[DX_N_SIMD];
    struct dx_rng rng = dx_rng_init(6, 3);
    const int n = find_sets(sets);

    (void)state;
    for (int k = 0; k < ROUNDS(500); k++) {
        struct dx_row_points point[2], sums;
        struct normals want, got;
        uint8_t code[DX_ROWS_N];

        any_sums(&point[0], &rng);
        any_sums(&point[1], &rng);
        any_sums(&sums, &rng);
        for (uint32_t j = 0; j < DX_ROWS_N; j++)
            code[j] = (uint8_t)dx_rng_below(&rng, 7);
        find_normals(&want, dx_rows_get(DX_SIMD_GENERIC), point, &sums, code);
        check_octahedral(&want, &sums, code);
        for (int s = 0; s < n; s++) {
            find_normals(&got, sets[s], point, &sums, code);
            assert_memory_equal(got.bytes, want.bytes, sizeof(want.bytes));
            assert_same_sums(&got.top, &want.top);
            assert_same_sums(&got.bottom, &want.bottom);
        }
    }
}

static void the_best_set_is_one_of_them(void **state)
{
    (void)state;
    assert_non_null(dx_rows_get(DX_SIMD_GENERIC));
    assert_non_null(dx_rows_get(DX_SIMD_AUTO));
    for (enum dx_simd k = DX_N_SIMD - 1; k > DX_SIMD_AUTO; k--)
        if (dx_rows_get(k)) {
            assert_ptr_equal(dx_rows_get(DX_SIMD_AUTO), dx_rows_get(k));
            break;
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_set_decides_alike),
        cmocka_unit_test(every_set_builds_alike),
        cmocka_unit_test(every_set_measures_alike),
        cmocka_unit_test(lengths_that_f32_cannot_square_are_told),
        cmocka_unit_test(every_set_finds_the_same_normals),
        cmocka_unit_test(the_best_set_is_one_of_them),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
