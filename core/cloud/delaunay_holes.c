#include "core/cloud/delaunay_priv.h"
int dx_delaunay_fill(struct dx_delaunay_run *run) { (void)run; return 0; }
