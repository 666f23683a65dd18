/*
 * Error text that travels with a negative return value: who fills it names the place (file, line or
 * byte offset), what was found and what was expected. Lives on the caller's stack; no thread shares
 * it.
 */
#ifndef DX_ERR_H
#define DX_ERR_H

struct dx_err {
    char text[512];
};

/* Formats into `err` (which may be NULL) and returns `code`, so that a failing function can end
 * with `return dx_err_set(err, -EINVAL, ...)`. Text that does not fit is cut. */
__attribute__((format(printf, 3, 4))) int dx_err_set(struct dx_err *err, int code, const char *fmt,
                                                     ...);

/* Puts "prefix: " before the text that is there. */
void dx_err_prefix(struct dx_err *err, const char *prefix);

#endif
