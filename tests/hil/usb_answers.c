/* What every simulated USB device answers to control requests: its descriptors, and the rest of the
 * standard ones. */
#include "tests/hil/redir_priv.h"

static int string_descriptor(const struct redir_device *device, unsigned index,
                             const uint8_t **bytes)
{
    static uint8_t text[2 + 2 * 126];
    static const uint8_t languages[4] = {4, TYPE_STRING, 0x09, 0x04};
    const char *s;
    size_t n;

    *bytes = languages;
    if (index == 0)
        return sizeof(languages);
    for (unsigned i = 1; i < index; i++)
        if (!device->strings[i - 1])
            return -1;
    s = device->strings[index - 1];
    if (!s)
        return -1;
    for (n = 0; n < 126 && s[n]; n++) {
        text[2 + 2 * n] = (uint8_t)s[n];
        text[3 + 2 * n] = 0;
    }
    text[0] = (uint8_t)(2 + 2 * n);
    text[1] = TYPE_STRING;
    *bytes = text;
    return text[0];
}

static int get_descriptor(const struct redir_device *device, const struct redir_setup *setup,
                          const uint8_t **bytes)
{
    switch (setup->value >> 8) {
    case TYPE_DEVICE:
        *bytes = device->device;
        return 18;
    case TYPE_CONFIG:
        *bytes = device->config;
        return (int)device->config_len;
    case TYPE_STRING:
        return string_descriptor(device, setup->value & 0xff, bytes);
    default:
        return -1;
    }
}

int redir_answer(const struct redir_device *device, const struct redir_setup *setup,
                 const uint8_t **bytes)
{
    static const uint8_t zero[2];

    if (setup->type == 0x80 && setup->request == 6)
        return get_descriptor(device, setup, bytes);
    if ((setup->type & 0x60) == 0) { /* standard: GET_STATUS, CLEAR_FEATURE ... */
        *bytes = zero;
        return setup->type & 0x80 ? 2 : 0;
    }
    return device->control(setup, bytes);
}
