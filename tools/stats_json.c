/* Mesh statistics as JSON. */
#include "tools/stats_json.h"

#include "tools/stdout.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>

json_t *dx_stats_json(const struct dx_mesh_stats *stats)
{
    char digest[17];
    json_t *o = json_object();

    snprintf(digest, sizeof(digest), "%016" PRIx64, stats->digest);
    json_object_set_new(o, "points", json_integer(stats->points));
    json_object_set_new(o, "triangles", json_integer(stats->triangles));
    json_object_set_new(o, "edges", json_integer((json_int_t)stats->edges));
    json_object_set_new(o, "boundary_edges", json_integer((json_int_t)stats->boundary_edges));
    json_object_set_new(o, "nonmanifold_edges", json_integer((json_int_t)stats->nonmanifold_edges));
    json_object_set_new(o, "duplicate_directed_edges",
                        json_integer((json_int_t)stats->duplicate_directed_edges));
    json_object_set_new(o, "components", json_integer(stats->components));
    json_object_set_new(o, "euler", json_integer(stats->euler));
    json_object_set_new(o, "digest", json_string(digest));
    return o;
}

json_t *dx_sigma_json(const double sigma[3])
{
    return json_pack("[f, f, f]", sigma[0], sigma[1], sigma[2]);
}

int dx_json_print(json_t *object, const char *command)
{
    int rc;

    if (json_dumpf(object, stdout, JSON_REAL_PRECISION(12)) != 0 && !ferror(stdout)) {
        fprintf(stderr, "%s: out of memory\n", command);
        rc = -ENOMEM;
    } else {
        putchar('\n');
        rc = dx_stdout_flush();
    }
    json_decref(object);
    return rc;
}
