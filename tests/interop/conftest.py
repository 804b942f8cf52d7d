"""Before any library is imported: one thread for each worker's linear algebra, of which two would wait for each other."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
