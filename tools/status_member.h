/* Members of a status that may not be there: service and tool need not be of one version. */
#ifndef DX_STATUS_MEMBER_H
#define DX_STATUS_MEMBER_H

#include <jansson.h>
#include <math.h>

/* A number at "key" or "key.member"; NAN where there is none. */
static inline double dx_status_number(const json_t *o, const char *key, const char *member)
{
    const json_t *v = json_object_get(o, key);

    if (member)
        v = json_object_get(v, member);
    return json_is_number(v) ? json_number_value(v) : (double)NAN;
}

/* "-" where there is none, or an empty one. */
static inline const char *dx_status_text(const json_t *o, const char *key)
{
    const char *s = json_string_value(json_object_get(o, key));

    return s && *s ? s : "-";
}

#endif
