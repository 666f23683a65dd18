/* Memory for arrays as long as a cloud: large ones in large pages, where the system has them. First
 * use of small pages takes longer than loading, and looking up where they are, as long as what is
 * read from them. To be freed by free(). */
#ifndef DX_PAGES_H
#define DX_PAGES_H

#include <stddef.h>

/* NULL: no memory. A length of 0 is fine. */
void *dx_pages_new(size_t len);
void *dx_pages_new_zeroed(size_t len);

#endif
