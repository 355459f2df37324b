/* fuzz/support/mesh_file.h - the targets of mesh files, which differ by the format only: reading,
 * what the mesh allows after that, and a mutator that changes meshes rather than bytes. */
#ifndef TULLE_FUZZ_MESH_FILE_H
#define TULLE_FUZZ_MESH_FILE_H

#include "support/fuzz.h"

/* What a mesh from a reader has to stand: being measured, validated, written and read again to the
 * same bits. Takes the mesh over. */
void fuzz_use_mesh(tulle_mesh *mesh);

/* Reads the input as the file `name`, whose extension is the format, by tulle_mesh_read_source. */
void fuzz_read_mesh_file(const char *name, const uint8_t *data, size_t size);

/* A small mesh of each kind, owned by the caller: a sheet, a closed box, a strip of a ring. */
enum { FUZZ_MESH_COUNT = 3 };
tulle_mesh fuzz_make_mesh(size_t kind);

/* Reads a mesh from the input, changes it as a mesh, and writes it back in the same format; reading
 * and writing by these functions. A mesh that was valid cloth stays so. Where the input is no mesh,
 * and now and then, the bytes are changed instead. For LLVMFuzzerCustomMutator. */
typedef tulle_status (*fuzz_mesh_reader)(const char *path, tulle_mesh *mesh);
typedef tulle_status (*fuzz_mesh_writer)(const char *path, tulle_mesh_view mesh);
typedef struct fuzz_mesh_format {
    const char *name; /* of a file of this format */
    fuzz_mesh_reader read;
    fuzz_mesh_writer write;
} fuzz_mesh_format;
size_t fuzz_mutate_mesh(const fuzz_mesh_format *format, uint8_t *data, size_t size, size_t size_max,
                        unsigned seed);
/* tulle_mesh_read and tulle_mesh_write without their errors. */
tulle_status fuzz_read_mesh(const char *path, tulle_mesh *mesh);
tulle_status fuzz_write_mesh(const char *path, tulle_mesh_view mesh);

/* The three meshes as seeds. */
void fuzz_put_mesh_seeds(const fuzz_mesh_format *format);

/* libFuzzer calls this one where a target has it. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned seed);

#endif
