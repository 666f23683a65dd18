/*
 * Levels of detail of a terrain mesh: right-triangulated irregular networks (Evans, Kirkpatrick and
 * Townsend 2001) over the 65x65 dexels of each tile, cut in the same places on both sides of every
 * tile border (ALGORITHMS 5.3, docs/terrain.md). A square of 64 cells is two right triangles, and a
 * triangle is halved at the middle of its hypotenuse for as long as the dexel there is active:
 *
 *   active   its error is above the bound asked for, or its triangle is above the stride
 *   error    how far the dexel lies from the plane of the triangle it would be left out of, in
 *            sigmas; at least that of every dexel whose triangle the split makes; infinite where a
 *            triangle beside it would cover a cell that does not have both of its triangles
 *
 * So the mesh keeps the boundary of the whole one, edge by edge, and near it, its cells and struts.
 * Errors are kept for each dexel of the grid, not of a tile: neighbours agree because they ask the
 * same ones. Owned by the terrain's mesher.
 */
#ifndef DX_LOD_H
#define DX_LOD_H

#include "core/grid/lod_level.h"
#include "core/grid/terrain.h"

#define DX_LOD_SLOTS 4 /* different levels of one stream at a time */

struct dx_lod;

/* For a terrain that has been given a frame, and stays. Finds what depends on the directions alone,
 * on the pool (NULL: on the caller). Every tile counts as noted. Errors: -ENOMEM. */
int dx_lod_new(struct dx_lod **out, const struct dx_terrain *t, struct dx_pool *pool);
void dx_lod_free(struct dx_lod *lod); /* NULL is fine */

/* After each commit: the tiles that it changed (dx_terrain_changed), for the next update. */
void dx_lod_note(struct dx_lod *lod, const uint64_t *changed);

/* Brings the errors up to date with the terrain. Allocates nothing. */
void dx_lod_update(struct dx_lod *lod, const struct dx_lod_level level[DX_LOD_SLOTS],
                   struct dx_pool *pool);

/* Tiles whose mesh at level[slot] the last update may have changed: those noted, and of their
 * neighbours those that are cut otherwise now. */
const uint64_t *dx_lod_changed(const struct dx_lod *lod, unsigned slot);

/* One a thread. */
struct dx_lod_scratch;
struct dx_lod_scratch *dx_lod_scratch_new(void); /* NULL: no memory */
void dx_lod_scratch_free(struct dx_lod_scratch *s);

/*
 * The mesh of a tile at a level, as of the last update: `whole` is that of all its cells
 * (dx_tile_mesh_build), whose vertices it takes some of, normals included. Triangles are those of
 * cells, of struts, then the larger ones. Any thread, while no update runs.
 */
void dx_lod_mesh(struct dx_tile_mesh *mesh, const struct dx_lod *lod, struct dx_lod_level level,
                 const struct dx_tile *tile, const struct dx_tile_mesh *whole,
                 struct dx_lod_scratch *scratch);

#endif
