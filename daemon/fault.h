/*
 * Faults on request, to test what the service does about them. A release has none: fault_none.c is
 * in its library, tests/faults/fault_switch.c takes its place in the tests' dexeld_faults.
 */
#ifndef DX_FAULT_H
#define DX_FAULT_H

enum dx_fault_place {
    DX_FAULT_LOOP,
    DX_FAULT_OPEN,     /* before the source of a stream is opened */
    DX_FAULT_READER,   /* before a block is decoded */
    DX_FAULT_MESHER,   /* before a frame is meshed */
    DX_FAULT_RECORDER, /* before a block is written */
};

/* Where a fault may strike. Any thread. */
void dx_fault_point(enum dx_fault_place place);

#endif
