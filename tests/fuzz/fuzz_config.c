/*
 * Fuzzing the configuration: no input may crash the parser; an error must have a text; what parses
 * must print as YAML that parses to the same.
 */
#include "daemon/config.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char *print(const struct dx_config *config, size_t *len)
{
    char *text = NULL;
    FILE *out = open_memstream(&text, len);

    if (!out)
        abort();
    dx_config_print(out, config);
    fclose(out);
    return text;
}

static void read_back(const struct dx_config *config)
{
    size_t len, len_again;
    char *text = print(config, &len), *text_again;
    struct dx_config again;
    struct dx_err err;

    if (dx_config_parse(&again, "printed", text, len, &err)) {
        fprintf(stderr, "%s\n%s", err.text, text);
        abort();
    }
    text_again = print(&again, &len_again);
    if (len != len_again || memcmp(text, text_again, len))
        abort();
    free(text);
    free(text_again);
    dx_config_fini(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct dx_config config;
    struct dx_err err = {""};
    int r = dx_config_parse(&config, "fuzz", data, size, &err);

    if (r == 0)
        read_back(&config);
    else if (r != -EINVAL || strncmp(err.text, "fuzz:", 5))
        abort();
    dx_config_fini(&config);
    return 0;
}
