/* The paper's table beside ours, as text and as JSON. */
#include "tools/bench_table.h"

#include "tools/stats_json.h"

#include <stdio.h>

const struct dx_table_row dx_table_paper[DX_TABLE_ARRAYS] = {
    {600, 400, 143858, 267131, 267131, 82.508, 5.998, 1.020},
    {1500, 1000, 883577, 1707468, 1707468, 88.554, 38.782, 6.913},
};

/* The lines of the table, from a row. */
static double points(const struct dx_table_row *r)
{
    return r->points;
}

static double fill(const struct dx_table_row *r)
{
    return 100 * r->points / ((double)r->width * r->height);
}

static double triangles(const struct dx_table_row *r)
{
    return r->triangles;
}

static double triangles_plain(const struct dx_table_row *r)
{
    return r->triangles_plain;
}

static double per_point(const struct dx_table_row *r)
{
    return r->triangles / r->points;
}

static double boundary(const struct dx_table_row *r)
{
    return 2 * r->points - r->triangles;
}

static double init_s(const struct dx_table_row *r)
{
    return r->init_s;
}

static double checks_s(const struct dx_table_row *r)
{
    return r->checks_s;
}

static double plain_s(const struct dx_table_row *r)
{
    return r->plain_s;
}

static double plain_ns(const struct dx_table_row *r)
{
    return 1e9 * r->plain_s / r->points;
}

static double checks_ns(const struct dx_table_row *r)
{
    return 1e9 * r->checks_s / r->points;
}

static const struct line {
    const char *name, *key;
    double (*value)(const struct dx_table_row *r);
    int decimals;
    bool speed; /* the ratio tells how many times faster we are; else how many times as many */
} lines[] = {
    {"points kept", "points", points, 0, false},
    {"of the array, %", "fill_percent", fill, 1, false},
    {"triangles, checks", "triangles", triangles, 0, false},
    {"triangles, without", "triangles_without", triangles_plain, 0, false},
    {"triangles a point", "triangles_per_point", per_point, 3, false},
    {"2V - T", "two_v_minus_t", boundary, 0, false},
    {"initialisation, s *", "init_s", init_s, 3, true},
    {"with checks, s", "checks_s", checks_s, 4, true},
    {"without, s", "without_s", plain_s, 4, true},
    {"with checks, ns/point", "checks_ns_per_point", checks_ns, 1, true},
    {"without, ns/point", "without_ns_per_point", plain_ns, 1, true},
};

#define N_LINES (sizeof(lines) / sizeof(lines[0]))

/* Milliseconds that the paper's points would take at this speed. */
static double paper_points_ms(int array, double ns_per_point)
{
    return dx_table_paper[array].points * ns_per_point * 1e-6;
}

static double ratio(const struct line *line, double here, double paper)
{
    return line->speed ? paper / here : here / paper;
}

void dx_table_print_text(const struct dx_table_row row[DX_TABLE_ARRAYS],
                         const struct dx_table_setup *setup)
{
    printf("%u samples of a simulated room (seed %llu, noise %g m, %g %% silent), keep %s,\n"
           "%u thread%s, medians of %u rounds; beside Gopi and Krishnan (2002), table 2\n\n",
           setup->n_samples, (unsigned long long)setup->seed, setup->noise_m, 100 * setup->silent,
           dx_keep_name(setup->keep), setup->n_threads, setup->n_threads > 1 ? "s" : "",
           setup->n_rounds);
    printf("%-22s", "");
    for (int k = 0; k < DX_TABLE_ARRAYS; k++)
        printf("    %13u x %4u     ", row[k].height, row[k].width);
    printf("\n%-22s", "");
    for (int k = 0; k < DX_TABLE_ARRAYS; k++)
        printf(" %10s %10s %7s", "here", "paper", "ratio");
    putchar('\n');
    for (const struct line *line = lines; line < lines + N_LINES; line++) {
        printf("%-22s", line->name);
        for (int k = 0; k < DX_TABLE_ARRAYS; k++) {
            double here = line->value(&row[k]), paper = line->value(&dx_table_paper[k]);

            printf(" %10.*f %10.*f %7.4g", line->decimals, here, line->decimals, paper,
                   ratio(line, here, paper));
        }
        putchar('\n');
    }
    for (int k = 0; k < DX_TABLE_ARRAYS; k++)
        printf("%sthe paper's %.0f points at this speed: %.2f ms with checks, %.2f ms without "
               "(paper %.0f, %.0f)\n",
               k ? "" : "\n", dx_table_paper[k].points, paper_points_ms(k, checks_ns(&row[k])),
               paper_points_ms(k, plain_ns(&row[k])), 1e3 * dx_table_paper[k].checks_s,
               1e3 * dx_table_paper[k].plain_s);
    puts("\n* the paper's includes reading the samples; 250 MHz R10000, one thread.\n"
         "ratio: here / paper; of times, paper / here.");
}

static json_t *row_json(const struct dx_table_row *row)
{
    json_t *j = json_object();

    for (const struct line *line = lines; line < lines + N_LINES; line++)
        json_object_set_new(j, line->key, json_real(line->value(row)));
    return j;
}

int dx_table_print_json(const struct dx_table_row row[DX_TABLE_ARRAYS],
                        const struct dx_table_setup *setup)
{
    json_t *j = json_object(), *arrays = json_array();

    for (int k = 0; k < DX_TABLE_ARRAYS; k++) {
        json_t *a = row_json(&row[k]);

        json_object_set_new(a, "width", json_integer(row[k].width));
        json_object_set_new(a, "height", json_integer(row[k].height));
        json_object_set_new(a, "paper_points_checks_ms",
                            json_real(paper_points_ms(k, checks_ns(&row[k]))));
        json_object_set_new(a, "paper_points_without_ms",
                            json_real(paper_points_ms(k, plain_ns(&row[k]))));
        json_object_set_new(a, "paper", row_json(&dx_table_paper[k]));
        json_array_append_new(arrays, a);
    }
    json_object_set_new(j, "samples", json_integer(setup->n_samples));
    json_object_set_new(j, "seed", json_integer((json_int_t)setup->seed));
    json_object_set_new(j, "noise", json_real(setup->noise_m));
    json_object_set_new(j, "silent", json_real(setup->silent));
    json_object_set_new(j, "keep", json_string(dx_keep_name(setup->keep)));
    json_object_set_new(j, "threads", json_integer(setup->n_threads));
    json_object_set_new(j, "rounds", json_integer(setup->n_rounds));
    json_object_set_new(j, "arrays", arrays);
    return dx_json_print(j, "dexel bench paper");
}
