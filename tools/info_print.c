/* The object of `dexel info` for people. */
#include "tools/info.h"

#include <stdio.h>

#define INDENT 2
#define COLUMN 20

static void print_value(const json_t *v)
{
    switch (json_typeof(v)) {
    case JSON_STRING:
        fputs(json_string_value(v), stdout);
        break;
    case JSON_INTEGER:
        printf("%lld", (long long)json_integer_value(v));
        break;
    case JSON_REAL:
        printf("%.9g", json_real_value(v));
        break;
    case JSON_TRUE:
        fputs("yes", stdout);
        break;
    case JSON_FALSE:
        fputs("no", stdout);
        break;
    case JSON_NULL: /* "sound" of what was not read */
        fputs("not checked", stdout);
        break;
    default: /* what is printed elsewhere */
        fputc('-', stdout);
    }
}

static void print_key(const char *key, int depth)
{
    int len = printf("%*s", depth * INDENT, "");

    for (const char *c = key; *c; c++, len++)
        putchar(*c == '_' ? ' ' : *c);
    printf("%*s", len < COLUMN ? COLUMN - len : 1, "");
}

static void print_object(const json_t *object, int depth);

static void print_list(const char *key, const json_t *list, int depth)
{
    const json_t *item;
    size_t k;

    json_array_foreach(list, k, item)
    {
        if (json_is_object(item)) {
            printf("%*s%s %zu\n", depth * INDENT, "", key, k + 1);
            print_object(item, depth + 1);
        } else {
            print_key(key, depth);
            print_value(item);
            putchar('\n');
        }
    }
}

static void print_object(const json_t *object, int depth)
{
    const char *key;
    json_t *v;

    json_object_foreach((json_t *)object, key, v)
    {
        if (json_is_array(v)) {
            print_list(key, v, depth);
        } else if (json_is_object(v)) {
            if (json_object_size(v) > 0)
                printf("%*s%s\n", depth * INDENT, "", key);
            print_object(v, depth + 1);
        } else {
            print_key(key, depth);
            print_value(v);
            putchar('\n');
        }
    }
}

void dx_info_print(const json_t *object)
{
    print_object(object, 0);
}
