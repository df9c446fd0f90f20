#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# CHOLMOD of SuiteSparse 5.12.0 (Debian 12) keeps no order that it is told to keep: with the only method CHOLMOD_NATURAL it still sorts
# the columns by the elimination tree (`postorder`, which is on), names the factor's order "postordered", and so each factorization of a
# lower triangle copies the whole matrix into that order. Whoever permuted the matrix beforehand pays a matrix of memory for nothing:
# with `postorder = 0` the order is natural, and nothing is copied.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
packages=(libmetis5=5.1.0.dfsg-7 libblas3=3.11.0-2 liblapack3=3.11.0-2)
for library in suitesparse-dev suitesparseconfig5 cholmod3 amd2 camd2 colamd2 ccolamd2; do packages+=("lib$library=1:5.12.0+dfsg-2"); done
apt-get download -qq "${packages[@]}" >/dev/null 2>&1
for package in *.deb; do dpkg -x "$package" packages; done
cat >natural.c <<'C'
#include <cholmod.h>
#include <stdio.h>

/* A chain of blocks of 30 unknowns, each tied to the next: its lower triangle, in an order without fill beyond neighbours. */
static cholmod_sparse *chain(cholmod_common *c) {
  const int block = 30, blocks = 400, n = block * blocks;
  cholmod_triplet *t = cholmod_allocate_triplet(n, n, (size_t)n * 2 * block, -1, CHOLMOD_REAL, c);
  for (int j = 0; j < n; ++j)
    for (int i = j; i < n && i / block <= j / block + 1; ++i) {
      ((int *)t->i)[t->nnz] = i;
      ((int *)t->j)[t->nnz] = j;
      ((double *)t->x)[t->nnz++] = i == j ? 4 * block : 1;
    }
  cholmod_sparse *a = cholmod_triplet_to_sparse(t, 0, c);
  cholmod_free_triplet(&t, c);
  return a;
}

static void factorize(int postorder) {
  cholmod_common c;
  cholmod_start(&c);
  c.supernodal = CHOLMOD_SUPERNODAL;
  c.nmethods = 1;
  c.method[0].ordering = CHOLMOD_NATURAL;
  c.postorder = postorder;
  cholmod_sparse *a = chain(&c);
  cholmod_factor *l = cholmod_analyze(a, &c);
  c.memory_usage = c.memory_inuse;
  const size_t before = c.memory_inuse;
  cholmod_factorize(a, l, &c);
  const double matrix = 12.0 * (double)cholmod_nnz(a, &c), factor = 8.0 * (double)l->xsize;
  printf("postorder %d: ordering %s, memory beside the factor %.0f matrices\n", postorder,
         l->ordering == CHOLMOD_NATURAL ? "natural" : l->ordering == CHOLMOD_POSTORDERED ? "postordered" : "other",
         ((double)(c.memory_usage - before) - factor) / matrix);
  cholmod_free_factor(&l, &c);
  cholmod_free_sparse(&a, &c);
  cholmod_finish(&c);
}

int main(void) {
  factorize(1);
  factorize(0);
  return 0;
}
C
folder_of() { dirname "$folder/$(find packages -name "$1" | head -1)"; }
libraries=$(folder_of libcholmod.so.3):$(folder_of libblas.so.3):$(folder_of liblapack.so.3)
gcc -I"$(folder_of cholmod.h)" natural.c -L"$(folder_of libcholmod.so.3)" -l:libcholmod.so.3 -Wl,--allow-shlib-undefined -o natural
LD_LIBRARY_PATH=$libraries ./natural | tee seen
printf 'postorder %s, memory beside the factor %s matrices\n' '1: ordering postordered' 1 '0: ordering natural' 0 | cmp seen -
