/*
 * The header of a PCD file: lines of keywords, up to and with DATA. Internal to the PCD reader.
 */
#ifndef DX_PCD_HEADER_H
#define DX_PCD_HEADER_H

#include "drivers/file/text_cursor.h"

#define DX_PCD_MAX_FIELDS 64
#define DX_PCD_MAX_NAME   32

enum dx_pcd_data { DX_PCD_ASCII, DX_PCD_BINARY, DX_PCD_COMPRESSED };

struct dx_pcd_field {
    char name[DX_PCD_MAX_NAME]; /* "_" is padding */
    char type;                  /* I, U or F */
    uint32_t size;              /* 1, 2, 4 or 8 bytes */
    uint32_t count;             /* values in a point */
    uint32_t offset;            /* in a point, bytes */
    uint32_t index;             /* of its first value among a point's */
};

struct dx_pcd_header {
    struct dx_pcd_field fields[DX_PCD_MAX_FIELDS];
    uint32_t n_fields;
    uint32_t stride;   /* bytes of a point */
    uint32_t n_values; /* of a point */
    uint32_t width, height;
    double viewpoint[7]; /* tx ty tz qw qx qy qz */
    enum dx_pcd_data data;
};

/* From the cursor, which is left at the data. Checks that the cloud is organized and all sizes are
 * within bounds. -EBADMSG. */
int dx_pcd_header_read(struct dx_pcd_header *h, struct dx_text_cursor *c);

/* The same for clouds of a single row as well, of at most DX_PLANE_MAX_DEXELS points. */
int dx_pcd_header_read_any(struct dx_pcd_header *h, struct dx_text_cursor *c);

/* NULL when there is none. */
const struct dx_pcd_field *dx_pcd_field_find(const struct dx_pcd_header *h, const char *name);

#endif
