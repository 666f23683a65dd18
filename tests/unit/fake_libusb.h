/*
 * A fake of libusb, linked before the real one: what drivers/usb calls, and no more. There is one
 * device at most, a simulated Kinect. It stands in where neither umockdev nor dummy_hcd can:
 * isochronous transfers. It keeps what callers rely on: callbacks run in handle_events alone, what
 * is cancelled comes back, after an unplug all comes back and nothing is taken; it cannot show how
 * the kernel or the bus behaves. One thread.
 */
#ifndef DX_FAKE_LIBUSB_H
#define DX_FAKE_LIBUSB_H

#include "tests/hil/kinect_sim.h"

struct fake_libusb {
    struct kinect_sim sim;
    bool plugged;
    int open_error, claim_error; /* of libusb */
    const char *serial;          /* NULL: that of a camera */
    unsigned burst;              /* isochronous transfers that come back in one round */
    bool never_return;           /* what is cancelled stays away */
    int transfer_status;         /* of isochronous transfers from now on */
    int packet_status;           /* of every 10th packet */
    unsigned unplug_after;       /* isochronous transfers; 0: not */
    uint64_t transfer_ns; /* from one isochronous transfer to the next; 0: as fast as asked */
    uint64_t due_ns;      /* when the next one comes back, then */
    uint64_t frame_ns;    /* when the last one with the end of a frame was due */
    /* What is there now, and what was. */
    int n_contexts, n_handles, n_transfers, n_flying, n_claimed, n_configs, n_lists;
    int alt;
    unsigned n_isochronous; /* transfers that came back */
    int flying_at_start;    /* when the stream's register was written */
};

extern struct fake_libusb fake_libusb;

/* A plugged-in camera of the first kind, nothing open. */
void fake_libusb_reset(void);

#endif
