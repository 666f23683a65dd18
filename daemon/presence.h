/*
 * What comes and goes: one monitor of sd-device for the subsystems that the configured streams'
 * devices are of. Each event of a subsystem pokes all of them, who look for themselves; duplicates
 * and events of other devices cost a look. Loop thread.
 */
#ifndef DX_PRESENCE_H
#define DX_PRESENCE_H

struct dx_presence;
struct sd_event;

int dx_presence_new(struct dx_presence **out); /* -ENOMEM */
void dx_presence_free(struct dx_presence *p);

/* Before the start, or after. `subsystems` ends with NULL; borrowed, as `ctx` is. -ENOMEM. */
int dx_presence_add(struct dx_presence *p, const char *const *subsystems, void (*poke)(void *ctx),
                    void *ctx);

/* Nobody pokes `ctx` any more. */
void dx_presence_remove(struct dx_presence *p, const void *ctx);

/* Nothing when nothing was added. Where no udevd runs, a warning: devices are then found by the
 * looks of their readers. */
void dx_presence_start(struct dx_presence *p, struct sd_event *event);

#endif
