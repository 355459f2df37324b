/* fuzz/targets/vtp.c - the reader of VTK PolyData files. */
#include "support/mesh_file.h"

#include "tulle_io/mesh_files.h"

#include <string.h>

static tulle_status read_vtp(const char *path, tulle_mesh *mesh) {
    return tulle_vtp_read(path, mesh, NULL, NULL);
}

static tulle_status write_vtp(const char *path, tulle_mesh_view mesh) {
    return tulle_vtp_write(path, mesh, NULL, NULL);
}

static const fuzz_mesh_format format = {"mesh.vtp", read_vtp, write_vtp};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *const path = fuzz_put_file(format.name, data, size);
    tulle_mesh mesh = {0}, again = {0};
    tulle_vtp_passed_over passed_over;
    tulle_error error = {0};
    tulle_status const status = tulle_vtp_read(path, &mesh, &passed_over, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(strcmp(error.file, path) == 0);
        FUZZ_CHECK(!mesh.positions && !mesh.triangles && !mesh.vertex_count);
        return 0;
    }
    tulle_mesh_view const view = tulle_mesh_get_view(&mesh);
    const char *const written = fuzz_path("again.vtp");
    FUZZ_CHECK_OK(tulle_vtp_write(written, view, mesh.positions, &error), &error);
    FUZZ_CHECK_OK(tulle_vtp_read(written, &again, &passed_over, &error), &error);
    FUZZ_CHECK(passed_over.lines == 0 && passed_over.vertex_cells == 0);
    FUZZ_CHECK(again.vertex_count == mesh.vertex_count);
    FUZZ_CHECK(again.triangle_count == mesh.triangle_count);
    FUZZ_CHECK(memcmp(again.positions, mesh.positions,
                      3 * mesh.vertex_count * sizeof *mesh.positions) == 0);
    tulle_mesh_destroy(&again);
    fuzz_use_mesh(&mesh);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned seed) {
    return fuzz_mutate_mesh(&format, data, size, size_max, seed);
}

void fuzz_make_seeds(void) {
    fuzz_put_mesh_seeds(&format);
    fuzz_put_text_seed(
        "text",
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
        "byte_order=\"LittleEndian\">\n<PolyData>\n<Piece NumberOfPoints=\"4\" NumberOfVerts=\"1\" "
        "NumberOfLines=\"1\" NumberOfStrips=\"0\" NumberOfPolys=\"2\">\n<PointData>\n"
        "<DataArray type=\"Float32\" Name=\"a\" format=\"ascii\">1 2 3 4</DataArray>\n"
        "</PointData>\n<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
        "format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 .5</DataArray></Points>\n<Polys>\n"
        "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 0 1 2 3"
        "</DataArray>\n<DataArray type=\"UInt8\" Name=\"offsets\" format=\"ascii\">3 7"
        "</DataArray>\n</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n");
    fuzz_put_text_seed(
        "appended",
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"BigEndian\" "
        "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"><PolyData>"
        "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><Points><DataArray type=\"Float64\" "
        "NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points><Polys>"
        "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"binary\">AAAAAAAAAAEAAA=="
        "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3</DataArray>"
        "</Polys></Piece></PolyData><AppendedData encoding=\"base64\">_AAAAAAAAAAEA"
        "</AppendedData></VTKFile>");
}
