/* io/animation/npz_write.c - writes an animation as a NumPy archive (.npz): a ZIP file of arrays,
 * not compressed, each a .npy file of version 1.0. Arrays of 4 GiB and more, and their places, are
 * in ZIP64.
 *
 * Based on: PKWARE, .ZIP File Format Specification, version 6.3.3, sections 4.3 and 4.5; NumPy
 * Enhancement Proposal 1.
 *
 * The header of an array holds its CRC-32, which is known at its end. So each array is made twice,
 * once for its sum. */
#include "base/error.h"
#include "io/animation/animation.h"
#include "io/bytes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

enum {
    HEADER_LIMIT = 192,  /* [bytes] of the head of an .npy file */
    HEADER_ALIGN = 64,   /* [bytes] it is a multiple of this */
    MEMBER_LIMIT = 7,    /* arrays */
    NAME_SIZE = 80,      /* [bytes] of the file of one */
    STORED_VERSION = 20, /* of ZIP that a reader needs, times 10 */
    ZIP64_VERSION = 45,
    ZIP64_EXTRA_SIZE = 20, /* [bytes] in a header: its own head, two sizes */
    FIRST_DAY = 0x21       /* 1 January 1980: files of the same contents are the same */
};

struct npz_writer;
typedef tulle_status (*member_function)(struct npz_writer *writer, tulle_error *error);

typedef struct npz_member {
    const char *name;
    member_function make;
    uint64_t place, size; /* [bytes] in the file, of the header; of the array's file */
    uint32_t sum;
} npz_member;

typedef struct npz_writer {
    animation_job *job;
    output_file *output;
    size_t member_count;
    bool is_summing; /* bytes are counted and summed, not written */
    uint64_t size;   /* [bytes] so far, of the member or of the file */
    uint32_t sum;
} npz_writer;

static void put(npz_writer *writer, const void *bytes, size_t byte_count) {
    writer->size += byte_count;
    if (!writer->is_summing) {
        output_write(writer->output, bytes, byte_count);
        return;
    }
    writer->sum = (uint32_t)crc32_z(writer->sum, bytes, byte_count);
}

static void put_number(npz_writer *writer, size_t byte_count, uint64_t value) {
    unsigned char bytes[8];
    bytes_store(bytes, byte_count, value);
    put(writer, bytes, byte_count);
}

static void put_double(npz_writer *writer, double value) {
    unsigned char bytes[8];
    bytes_store_double(bytes, value);
    put(writer, bytes, sizeof bytes);
}

/* The head of an .npy file. type: "<f4"; shape: "(3,)". */
static void put_head(npz_writer *writer, const char *type, const char *shape) {
    char head[HEADER_LIMIT];
    memset(head, ' ', sizeof head);
    memcpy(head, "\x93NUMPY\1\0", 8);
    int const length =
        snprintf(head + 10, sizeof head - 10,
                 "{'descr': '%s', 'fortran_order': False, 'shape': %s, }", type, shape);
    head[10 + length] = ' ';
    size_t const size = (10 + (size_t)length + HEADER_ALIGN) / HEADER_ALIGN * HEADER_ALIGN;
    head[size - 1] = '\n';
    bytes_store(head + 8, 2, size - 10);
    put(writer, head, size);
}

/* ---- arrays ---- */

static uint64_t count_vertices(const tulle_animation_def *def, size_t surface_count) {
    uint64_t count = 0;
    for (size_t i = 0; i < surface_count; i++) count += def->surfaces[i].mesh.vertex_count;
    return count;
}

static uint64_t count_triangles(const tulle_animation_def *def, size_t surface_count) {
    uint64_t count = 0;
    for (size_t i = 0; i < surface_count; i++) count += def->surfaces[i].mesh.triangle_count;
    return count;
}

/* A number of the animation. */
static void put_value(npz_writer *writer, double value) {
    unsigned char bytes[4];
    if (writer->job->def->is_double) {
        put_double(writer, value);
        return;
    }
    bytes_store_float(bytes, (float)value);
    put(writer, bytes, sizeof bytes);
}

static tulle_status make_positions(npz_writer *writer, tulle_error *error) {
    const tulle_animation_def *const def = writer->job->def;
    char shape[80];
    snprintf(shape, sizeof shape, "(%u, %llu, 3)", def->frame_count,
             (unsigned long long)count_vertices(def, def->surface_count));
    put_head(writer, def->is_double ? "<f8" : "<f4", shape);
    for (uint32_t frame = 0; frame < def->frame_count; frame++)
        for (size_t i = 0; i < def->surface_count; i++) {
            tulle_status const status = animation_read(writer->job, i, frame, error);
            if (status) return status;
            for (size_t k = 0; k < 3 * def->surfaces[i].mesh.vertex_count; k++)
                put_value(writer, writer->job->positions[k]);
        }
    return TULLE_OK;
}

static tulle_status make_vertex_array(npz_writer *writer, tulle_error *error) {
    const animation_job *const job = writer->job;
    const tulle_animation_def *const def = job->def;
    char shape[80];
    snprintf(shape, sizeof shape, "(%u, %llu)", def->frame_count,
             (unsigned long long)count_vertices(def, def->surface_count));
    put_head(writer, def->is_double ? "<f8" : "<f4", shape);
    for (uint32_t frame = 0; frame < def->frame_count; frame++)
        for (size_t i = 0; i < def->surface_count; i++) {
            tulle_status const status =
                def->read_vertex_array(def->context, i, frame, job->positions, error);
            if (status) return status;
            for (size_t k = 0; k < def->surfaces[i].mesh.vertex_count; k++) {
                if (!isfinite((float)job->positions[k]))
                    return error_set_at(
                        error, TULLE_ERROR_INVALID_MESH, job->path, 0, 0,
                        "%s, frame %u, vertex %zu: %s is %g, which float cannot hold",
                        def->surfaces[i].name, frame, k, def->vertex_array, job->positions[k]);
                put_value(writer, job->positions[k]);
            }
        }
    return TULLE_OK;
}

static tulle_status make_triangles(npz_writer *writer, tulle_error *error) {
    (void)error;
    const tulle_animation_def *const def = writer->job->def;
    char shape[80];
    snprintf(shape, sizeof shape, "(%llu, 3)",
             (unsigned long long)count_triangles(def, def->surface_count));
    put_head(writer, "<i8", shape);
    for (size_t i = 0; i < def->surface_count; i++) {
        uint64_t const first = count_vertices(def, i);
        for (size_t k = 0; k < 3 * def->surfaces[i].mesh.triangle_count; k++)
            put_number(writer, 8, first + def->surfaces[i].mesh.triangles[k]);
    }
    return TULLE_OK;
}

static tulle_status make_times(npz_writer *writer, tulle_error *error) {
    (void)error;
    const tulle_animation_def *const def = writer->job->def;
    char shape[80];
    snprintf(shape, sizeof shape, "(%u,)", def->frame_count);
    put_head(writer, "<f8", shape);
    for (uint32_t i = 0; i < def->frame_count; i++) put_double(writer, def->times[i]);
    return TULLE_OK;
}

/* Takes a character off a text in UTF-8; a byte that begins none becomes U+FFFD. 0 at the end. */
static uint32_t take_character(const char **text) {
    const unsigned char *const c = (const unsigned char *)*text;
    static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
    if (!*c) return 0;
    size_t const length = *c < 0x80 ? 1 : *c >= 0xf0 ? 4 : *c >= 0xe0 ? 3 : 2;
    uint32_t code = length == 1 ? *c : *c & (0x7fu >> length);
    bool is_good = *c < 0x80 || (*c >= 0xc2 && *c < 0xf8);
    size_t used = 1;
    for (; used < length && is_good; used++) {
        is_good = (c[used] & 0xc0) == 0x80;
        code = code << 6 | (c[used] & 0x3f);
    }
    is_good =
        is_good && code >= least[length] && code <= 0x10ffff && !(code >= 0xd800 && code <= 0xdfff);
    *text += is_good ? length : 1;
    return is_good ? code : 0xfffd;
}

static tulle_status make_names(npz_writer *writer, tulle_error *error) {
    (void)error;
    const tulle_animation_def *const def = writer->job->def;
    size_t longest = 1;
    for (size_t i = 0; i < def->surface_count; i++) {
        const char *name = def->surfaces[i].name;
        size_t length = 0;
        while (take_character(&name)) length++;
        if (length > longest) longest = length;
    }
    char type[32], shape[80];
    snprintf(type, sizeof type, "<U%zu", longest);
    snprintf(shape, sizeof shape, "(%zu,)", def->surface_count);
    put_head(writer, type, shape);
    for (size_t i = 0; i < def->surface_count; i++) {
        const char *name = def->surfaces[i].name;
        for (size_t k = 0; k < longest; k++) put_number(writer, 4, take_character(&name));
    }
    return TULLE_OK;
}

/* Where the parts of each surface begin, and the end. */
static void make_firsts(npz_writer *writer,
                        uint64_t (*count)(const tulle_animation_def *def, size_t surface_count)) {
    const tulle_animation_def *const def = writer->job->def;
    char shape[80];
    snprintf(shape, sizeof shape, "(%zu,)", def->surface_count + 1);
    put_head(writer, "<i8", shape);
    for (size_t i = 0; i <= def->surface_count; i++) put_number(writer, 8, count(def, i));
}

static tulle_status make_first_vertices(npz_writer *writer, tulle_error *error) {
    (void)error;
    make_firsts(writer, count_vertices);
    return TULLE_OK;
}

static tulle_status make_first_triangles(npz_writer *writer, tulle_error *error) {
    (void)error;
    make_firsts(writer, count_triangles);
    return TULLE_OK;
}

/* ---- the archive ---- */

static bool is_large(uint64_t value) { return value >= UINT32_MAX; }

/* What a member's header and its entry in the directory have in common, from the version needed up
 * to the length of the name. */
static void put_facts(npz_writer *writer, const npz_member *member, bool is_zip64) {
    uint64_t const size = is_large(member->size) ? UINT32_MAX : member->size;
    put_number(writer, 2, is_zip64 ? ZIP64_VERSION : STORED_VERSION);
    put_number(writer, 2, 0); /* flags */
    put_number(writer, 2, 0); /* stored */
    put_number(writer, 2, 0); /* time */
    put_number(writer, 2, FIRST_DAY);
    put_number(writer, 4, member->sum);
    put_number(writer, 4, size);
    put_number(writer, 4, size);
    put_number(writer, 2, strlen(member->name));
}

static tulle_status put_member(npz_writer *writer, npz_member *member, tulle_error *error) {
    uint64_t const place = writer->size;
    writer->is_summing = true;
    writer->size = 0;
    writer->sum = 0;
    tulle_status const status = member->make(writer, error);
    member->place = place;
    member->size = writer->size;
    member->sum = writer->sum;
    writer->is_summing = false;
    writer->size = place;
    if (status) return status;
    bool const is_zip64 = is_large(member->size);
    put(writer, "PK\3\4", 4);
    put_facts(writer, member, is_zip64);
    put_number(writer, 2, is_zip64 ? ZIP64_EXTRA_SIZE : 0);
    put(writer, member->name, strlen(member->name));
    if (is_zip64) {
        put_number(writer, 2, 1);
        put_number(writer, 2, ZIP64_EXTRA_SIZE - 4);
        put_number(writer, 8, member->size);
        put_number(writer, 8, member->size);
    }
    return member->make(writer, error);
}

static void put_entry(npz_writer *writer, const npz_member *member) {
    bool const has_size = is_large(member->size), has_place = is_large(member->place);
    size_t const extra_size =
        (has_size || has_place) ? 4 + 16 * (size_t)has_size + 8 * (size_t)has_place : 0;
    put(writer, "PK\1\2", 4);
    put_number(writer, 2, extra_size > 0 ? ZIP64_VERSION : STORED_VERSION); /* made by */
    put_facts(writer, member, extra_size > 0);
    put_number(writer, 2, extra_size);
    put_number(writer, 2, 0); /* comment */
    put_number(writer, 2, 0); /* disk */
    put_number(writer, 2, 0); /* attributes */
    put_number(writer, 4, 0);
    put_number(writer, 4, has_place ? UINT32_MAX : member->place);
    put(writer, member->name, strlen(member->name));
    if (extra_size == 0) return;
    put_number(writer, 2, 1);
    put_number(writer, 2, extra_size - 4);
    for (int i = 0; i < 2 && has_size; i++) put_number(writer, 8, member->size);
    if (has_place) put_number(writer, 8, member->place);
}

static void put_directory(npz_writer *writer, const npz_member *members) {
    uint64_t const place = writer->size;
    for (size_t i = 0; i < writer->member_count; i++) put_entry(writer, &members[i]);
    uint64_t const size = writer->size - place;
    if (is_large(place)) {
        uint64_t const end = writer->size;
        put(writer, "PK\6\6", 4);
        put_number(writer, 8, 44); /* bytes that follow */
        put_number(writer, 2, ZIP64_VERSION);
        put_number(writer, 2, ZIP64_VERSION);
        put_number(writer, 4, 0); /* disks */
        put_number(writer, 4, 0);
        put_number(writer, 8, writer->member_count);
        put_number(writer, 8, writer->member_count);
        put_number(writer, 8, size);
        put_number(writer, 8, place);
        put(writer, "PK\6\7", 4);
        put_number(writer, 4, 0);
        put_number(writer, 8, end);
        put_number(writer, 4, 1);
    }
    put(writer, "PK\5\6", 4);
    put_number(writer, 4, 0); /* disks */
    put_number(writer, 2, writer->member_count);
    put_number(writer, 2, writer->member_count);
    put_number(writer, 4, size);
    put_number(writer, 4, is_large(place) ? UINT32_MAX : place);
    put_number(writer, 2, 0); /* comment */
}

tulle_status npz_write(animation_job *job, tulle_error *error) {
    npz_member members[MEMBER_LIMIT] = {
        {.name = "positions.npy", .make = make_positions},
        {.name = "triangles.npy", .make = make_triangles},
        {.name = "times.npy", .make = make_times},
        {.name = "names.npy", .make = make_names},
        {.name = "first_vertices.npy", .make = make_first_vertices},
        {.name = "first_triangles.npy", .make = make_first_triangles}};
    npz_writer writer = {.job = job, .member_count = MEMBER_LIMIT - 1};
    char name[NAME_SIZE];
    if (job->def->vertex_array) {
        snprintf(name, sizeof name, "%s.npy", job->def->vertex_array);
        members[writer.member_count++] = (npz_member){.name = name, .make = make_vertex_array};
    }
    for (size_t i = 0; i < job->def->surface_count; i++)
        if (job->def->surfaces[i].motion == TULLE_ANIMATION_RIGID)
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, job->path, 0, 0,
                                "an NPZ archive holds vertices, not poses: %s is rigid",
                                job->def->surfaces[i].name);
    tulle_status status = output_open(job->path, &writer.output, error);
    if (status) return status;
    for (size_t i = 0; i < writer.member_count && status == TULLE_OK; i++)
        status = put_member(&writer, &members[i], error);
    if (status == TULLE_OK) {
        put_directory(&writer, members);
        return output_commit(writer.output, error);
    }
    output_discard(writer.output);
    return status;
}
