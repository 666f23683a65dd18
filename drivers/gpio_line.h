/*
 * How a configuration names a GPIO line, and the words for what is asked of it. Pure functions, any
 * thread.
 */
#ifndef DX_GPIO_LINE_H
#define DX_GPIO_LINE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum dx_gpio_bias {
    DX_GPIO_AS_IS = 0,
    DX_GPIO_DISABLED = 1,
    DX_GPIO_PULL_UP = 2,
    DX_GPIO_PULL_DOWN = 3
};

enum dx_gpio_edges {
    DX_GPIO_NO_EDGE = 0,
    DX_GPIO_RISING = 1,
    DX_GPIO_FALLING = 2,
    DX_GPIO_BOTH = 3
};

/* A line is "CHIP:OFFSET" (gpiochip0:17, /dev/gpiochip0:17) or the name that the board gives it
 * (encoder-a). NULL: it can be one; else why not. An empty text is no line. */
const char *dx_gpio_where_check(const char *where);

/* Do both name one line? Of a line that one names by its chip and the other by its name the kernel
 * alone would know. */
bool dx_gpio_where_same(const char *a, const char *b);

/* Is there a line at all? A configuration says "none" where there is not. */
static inline bool dx_gpio_where_given(const char *where)
{
    return where && *where && strcmp(where, "none");
}

#endif
