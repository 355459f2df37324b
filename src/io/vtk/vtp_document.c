/* io/vtk/vtp_document.c - reads the structure of a VTK XML PolyData file with Expat.
 *
 * The file is XML up to the element AppendedData, whose contents may be raw bytes: there Expat is
 * stopped, and what stands behind the underscore is addressed by the arrays' offsets. The text of
 * arrays that are not needed (point data, lines) is passed over, not kept. Documents with a type
 * declaration are refused, so no entity can expand.
 *
 * Based on: Kitware, VTK file formats, the XML formats. */
#include "io/vtk/vtp_document.h"

#include "base/error.h"

#include <expat.h>
#include <string.h>

enum {
    FED_BYTES = 1 << 20, /* [bytes] given to Expat at once */
    DEPTH_MAX = 5, /* elements deeper than VTKFile/PolyData/Piece/Points/DataArray are not read */
    NESTING_LIMIT = 64, /* so that a file of opening tags alone takes no memory */
    PIECE_LIMIT = 1 << 16
};

typedef enum element {
    ELEMENT_OTHER,
    ELEMENT_FILE,
    ELEMENT_POLYDATA,
    ELEMENT_PIECE,
    ELEMENT_POINTS,
    ELEMENT_POLYGONS,
    ELEMENT_ARRAY
} element;

typedef struct vtp_parser {
    XML_Parser expat;
    vtp_document *document;
    element path[DEPTH_MAX]; /* the open elements */
    int depth;
    vtp_array *array; /* whose text is being read, or null */
    bool is_stopped;  /* at AppendedData */
    tulle_status status;
    tulle_error *error;
} vtp_parser;

static int get_line(const vtp_parser *parser) {
    XML_Size const line = XML_GetCurrentLineNumber(parser->expat);
    return line < INT32_MAX ? (int)line : INT32_MAX;
}

/* Remembers the first failure and ends the parsing. */
#define FAIL(parser, code, ...)                                                                    \
    ((parser)->status = (parser)->status != TULLE_OK                                               \
                            ? (parser)->status                                                     \
                            : error_set_at((parser)->error, (code), (parser)->document->path,      \
                                           get_line(parser), 0, __VA_ARGS__),                      \
     (void)XML_StopParser((parser)->expat, XML_FALSE))

static const char *find_attribute(const XML_Char **attributes, const char *name) {
    for (; *attributes; attributes += 2)
        if (strcmp(attributes[0], name) == 0) return attributes[1];
    return NULL;
}

/* A whole number without sign; blanks may stand around it. A missing attribute is `missing`. */
static uint64_t read_count(vtp_parser *parser, const XML_Char **attributes, const char *name,
                           uint64_t missing) {
    const char *const text = find_attribute(attributes, name);
    if (!text) return missing;
    const char *at = text;
    while (*at == ' ') at++;
    uint64_t value = 0;
    bool is_number = *at >= '0' && *at <= '9';
    for (; *at >= '0' && *at <= '9'; at++) {
        is_number = is_number && value <= (INT64_MAX - 9) / 10;
        value = value * 10 + (uint64_t)(*at - '0');
    }
    while (*at == ' ') at++;
    if (is_number && *at == '\0') return value;
    FAIL(parser, TULLE_ERROR_PARSE, "%s=\"%.40s\" should be a whole number from 0", name, text);
    return missing;
}

/* ---- elements ---- */

static void read_file_element(vtp_parser *parser, const char *name, const XML_Char **attributes) {
    vtp_document *const document = parser->document;
    if (strcmp(name, "VTKFile") != 0) {
        FAIL(parser, TULLE_ERROR_PARSE, "begins with <%.40s>, so it is not a VTK XML file", name);
        return;
    }
    const char *const type = find_attribute(attributes, "type");
    const char *const order = find_attribute(attributes, "byte_order");
    const char *const header = find_attribute(attributes, "header_type");
    const char *const compressor = find_attribute(attributes, "compressor");
    if (!type || strcmp(type, "PolyData") != 0)
        FAIL(parser, TULLE_ERROR_UNSUPPORTED,
             "holds %.40s; only PolyData can be read (in ParaView: Extract Surface)",
             type ? type : "data of no type");
    if (order && strcmp(order, "LittleEndian") != 0 && strcmp(order, "BigEndian") != 0)
        FAIL(parser, TULLE_ERROR_PARSE, "byte_order=\"%.40s\" should be LittleEndian or BigEndian",
             order);
    if (header && strcmp(header, "UInt32") != 0 && strcmp(header, "UInt64") != 0)
        FAIL(parser, TULLE_ERROR_PARSE, "header_type=\"%.40s\" should be UInt32 or UInt64", header);
    if (compressor && *compressor && strcmp(compressor, "vtkZLibDataCompressor") != 0)
        FAIL(parser, TULLE_ERROR_UNSUPPORTED,
             "is compressed by %.60s; only vtkZLibDataCompressor can be read (in ParaView: choose "
             "ZLib or None when saving)",
             compressor);
    document->is_big_endian = order && strcmp(order, "BigEndian") == 0;
    document->header_size = header && strcmp(header, "UInt64") == 0 ? 8 : 4;
    document->is_compressed = compressor && *compressor;
}

static void add_piece(vtp_parser *parser, const XML_Char **attributes) {
    vtp_document *const document = parser->document;
    vtp_piece const piece = {.point_count = read_count(parser, attributes, "NumberOfPoints", 0),
                             .polygon_count = read_count(parser, attributes, "NumberOfPolys", 0),
                             .vertex_cell_count =
                                 read_count(parser, attributes, "NumberOfVerts", 0),
                             .line_count = read_count(parser, attributes, "NumberOfLines", 0),
                             .strip_count = read_count(parser, attributes, "NumberOfStrips", 0),
                             .line = get_line(parser)};
    if (document->pieces.count == PIECE_LIMIT) {
        FAIL(parser, TULLE_ERROR_LIMIT, "has more than %d pieces", PIECE_LIMIT);
        return;
    }
    if (!ARRAY_RESERVE(&document->heap, &document->pieces, 1)) {
        FAIL(parser, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the pieces of the file");
        return;
    }
    document->pieces.data[document->pieces.count++] = piece;
}

static bool find_type(const char *name, vtp_type *type) {
    static const char *const names[VTP_TYPE_COUNT] = {"Int8",    "UInt8",  "Int16", "UInt16",
                                                      "Int32",   "UInt32", "Int64", "UInt64",
                                                      "Float32", "Float64"};
    for (int i = 0; i < VTP_TYPE_COUNT; i++) {
        if (strcmp(names[i], name) != 0) continue;
        *type = (vtp_type)i;
        return true;
    }
    return false;
}

static bool find_format(const char *name, vtp_format *format) {
    static const char *const names[] = {"ascii", "binary", "appended"};
    for (int i = 0; i < 3; i++) {
        if (strcmp(names[i], name) != 0) continue;
        *format = (vtp_format)i;
        return true;
    }
    return false;
}

/* The array of the piece at hand that a DataArray element fills, or null. */
static vtp_array *find_array(const vtp_parser *parser, const XML_Char **attributes) {
    vtp_document *const document = parser->document;
    vtp_piece *const piece = &document->pieces.data[document->pieces.count - 1];
    if (parser->path[3] == ELEMENT_POINTS) return &piece->points;
    const char *const name = find_attribute(attributes, "Name");
    if (name && strcmp(name, "connectivity") == 0) return &piece->connectivity;
    if (name && strcmp(name, "offsets") == 0) return &piece->offsets;
    return NULL;
}

static void begin_array(vtp_parser *parser, const XML_Char **attributes) {
    vtp_array *const array = find_array(parser, attributes);
    if (!array) return;
    const char *const type = find_attribute(attributes, "type");
    const char *const format = find_attribute(attributes, "format");
    if (array->is_there) FAIL(parser, TULLE_ERROR_PARSE, "the piece has this array twice");
    array->line = get_line(parser);
    array->component_count = read_count(parser, attributes, "NumberOfComponents", 1);
    array->format = VTP_ASCII;
    if (!type || !find_type(type, &array->type))
        FAIL(parser, TULLE_ERROR_PARSE,
             "the array's type \"%.40s\" should be Int8 to UInt64, Float32 or Float64",
             type ? type : "");
    if (format && !find_format(format, &array->format))
        FAIL(parser, TULLE_ERROR_PARSE, "format=\"%.40s\" should be ascii, binary or appended",
             format);
    if (array->format == VTP_APPENDED && !find_attribute(attributes, "offset"))
        FAIL(parser, TULLE_ERROR_PARSE, "the array is appended, but has no offset");
    array->offset = read_count(parser, attributes, "offset", 0);
    array->is_there = true;
    if (array->format != VTP_APPENDED) parser->array = array;
}

/* Stops the parser and finds what stands behind the underscore. */
static void begin_appended(vtp_parser *parser, const XML_Char **attributes) {
    vtp_document *const document = parser->document;
    const char *const encoding = find_attribute(attributes, "encoding");
    bool const is_raw = !encoding || strcmp(encoding, "raw") == 0;
    if (!is_raw && strcmp(encoding, "base64") != 0)
        FAIL(parser, TULLE_ERROR_UNSUPPORTED,
             "encoding=\"%.40s\" of the appended data should be raw or base64", encoding);
    size_t at = (size_t)XML_GetCurrentByteIndex(parser->expat) +
                (size_t)XML_GetCurrentByteCount(parser->expat);
    while (at < document->byte_count && strchr(" \t\r\n", document->bytes[at]) &&
           document->bytes[at])
        at++;
    if (at >= document->byte_count || document->bytes[at] != '_') {
        FAIL(parser, TULLE_ERROR_PARSE, "byte %zu: appended data should begin with an underscore",
             at);
        return;
    }
    document->has_appended = true;
    document->is_appended_raw = is_raw;
    document->appended_begin = at + 1;
    document->appended_end = document->byte_count;
    const char *const end =
        is_raw ? NULL : memchr(document->bytes + at, '<', document->byte_count - at);
    if (end) document->appended_end = (size_t)(end - document->bytes);
    parser->is_stopped = true;
    XML_StopParser(parser->expat, XML_FALSE);
}

/* What an element below the open ones is. */
static element classify(const vtp_parser *parser, const char *name) {
    element const parent = parser->depth > 0 ? parser->path[parser->depth - 1] : ELEMENT_OTHER;
    if (parser->depth == 0) return ELEMENT_FILE;
    if (parent == ELEMENT_FILE && strcmp(name, "PolyData") == 0) return ELEMENT_POLYDATA;
    if (parent == ELEMENT_POLYDATA && strcmp(name, "Piece") == 0) return ELEMENT_PIECE;
    if (parent == ELEMENT_PIECE && strcmp(name, "Points") == 0) return ELEMENT_POINTS;
    if (parent == ELEMENT_PIECE && strcmp(name, "Polys") == 0) return ELEMENT_POLYGONS;
    bool const is_in_arrays = parent == ELEMENT_POINTS || parent == ELEMENT_POLYGONS;
    return is_in_arrays && strcmp(name, "DataArray") == 0 ? ELEMENT_ARRAY : ELEMENT_OTHER;
}

/* ---- what Expat calls ---- */

static void on_start(void *context, const XML_Char *name, const XML_Char **attributes) {
    vtp_parser *const parser = context;
    if (parser->status != TULLE_OK || parser->is_stopped) return;
    if (parser->depth < DEPTH_MAX) {
        element const kind = classify(parser, name);
        parser->path[parser->depth] = kind;
        if (kind == ELEMENT_FILE) read_file_element(parser, name, attributes);
        if (kind == ELEMENT_PIECE) add_piece(parser, attributes);
        if (kind == ELEMENT_ARRAY) begin_array(parser, attributes);
        if (parser->depth == 1 && strcmp(name, "AppendedData") == 0)
            begin_appended(parser, attributes);
    }
    if (++parser->depth > NESTING_LIMIT)
        FAIL(parser, TULLE_ERROR_LIMIT, "more than %d elements are nested", NESTING_LIMIT);
}

static void on_end(void *context, const XML_Char *name) {
    (void)name;
    vtp_parser *const parser = context;
    parser->depth--;
    if (parser->depth < DEPTH_MAX) parser->array = NULL;
}

static void on_text(void *context, const XML_Char *text, int length) {
    vtp_parser *const parser = context;
    vtp_array *const array = parser->array;
    if (parser->status != TULLE_OK || !array || parser->depth != DEPTH_MAX) return;
    size_t const count = (size_t)length;
    if (!ARRAY_RESERVE(&parser->document->heap, &array->text, count)) {
        FAIL(parser, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for an array of the file");
        return;
    }
    memcpy(array->text.data + array->text.count, text, count);
    array->text.count += count;
}

static void on_doctype(void *context, const XML_Char *name, const XML_Char *system_id,
                       const XML_Char *public_id, int has_internal_subset) {
    (void)name, (void)system_id, (void)public_id, (void)has_internal_subset;
    vtp_parser *const parser = context;
    FAIL(parser, TULLE_ERROR_UNSUPPORTED, "has a document type declaration, which no VTK file has");
}

static tulle_status feed(vtp_parser *parser) {
    const vtp_document *const document = parser->document;
    for (size_t at = 0; at < document->byte_count || at == 0;) {
        size_t const left = document->byte_count - at;
        size_t const count = left < FED_BYTES ? left : FED_BYTES;
        enum XML_Status const outcome =
            XML_Parse(parser->expat, document->bytes + at, (int)count, count == left);
        if (parser->status != TULLE_OK || parser->is_stopped) return parser->status;
        if (outcome != XML_STATUS_OK) {
            enum XML_Error const code = XML_GetErrorCode(parser->expat);
            return error_set_at(parser->error,
                                code == XML_ERROR_NO_MEMORY ? TULLE_ERROR_OUT_OF_MEMORY
                                                            : TULLE_ERROR_PARSE,
                                document->path, get_line(parser),
                                (int)(XML_GetCurrentColumnNumber(parser->expat) % INT32_MAX) + 1,
                                "is cut short or no XML: %s", XML_ErrorString(code));
        }
        at += count;
        if (count == left) break;
    }
    return TULLE_OK;
}

tulle_status vtp_document_read(const char *path, const char *bytes, size_t byte_count,
                               vtp_document *document, tulle_error *error) {
    *document = (vtp_document){
        .heap = memory_default(), .path = path, .bytes = bytes, .byte_count = byte_count};
    vtp_parser parser = {.document = document, .error = error};
    parser.expat = XML_ParserCreate(NULL);
    if (!parser.expat)
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                            "out of memory for reading XML");
    XML_SetUserData(parser.expat, &parser);
    XML_SetElementHandler(parser.expat, on_start, on_end);
    XML_SetCharacterDataHandler(parser.expat, on_text);
    XML_SetStartDoctypeDeclHandler(parser.expat, on_doctype);
    tulle_status const status = feed(&parser);
    XML_ParserFree(parser.expat);
    return status;
}

void vtp_document_destroy(vtp_document *document) {
    for (size_t i = 0; i < document->pieces.count; i++) {
        vtp_piece *const piece = &document->pieces.data[i];
        ARRAY_FREE(&document->heap, &piece->points.text);
        ARRAY_FREE(&document->heap, &piece->connectivity.text);
        ARRAY_FREE(&document->heap, &piece->offsets.text);
    }
    ARRAY_FREE(&document->heap, &document->pieces);
}
