/* io/animation/alembic.cpp - animations in the format Alembic (.abc, Ogawa), by the library of that
 * name, which is C++: built with TULLE_ALEMBIC alone. Surfaces are polygon meshes; rigid ones have
 * a transform above them.
 *
 * Faces of Alembic go around clockwise as seen from outside, so triangles are turned over on their
 * way out and in. The format says nothing of axes and units; its users take y to point up. */
extern "C" {
#include "base/error.h"
#include "geom/cut_polygon.h"
#include "io/animation/animation.h"
#include "io/animation/animation_read.h"
}

#include <Alembic/AbcCoreOgawa/All.h>
#include <Alembic/AbcGeom/All.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <ostream>
#include <set>
#include <streambuf>
#include <string>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace abc = Alembic::Abc;
namespace geom = Alembic::AbcGeom;

namespace {

const size_t vertex_limit = INT32_MAX, frame_limit = INT32_MAX;

/* What the library throws, a full disk or a lack of memory, as a status. */
tulle_status tell_exception(const char *path, tulle_error *error) {
    try {
        throw;
    } catch (const std::bad_alloc &) {
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0, "no memory left");
    } catch (const std::ios_base::failure &thrown) {
        bool const is_full = thrown.code() == std::errc::no_space_on_device;
        return error_set_at(error, is_full ? TULLE_ERROR_DISK_FULL : TULLE_ERROR_IO, path, 0, 0,
                            "cannot be written: %.200s", thrown.code().message().c_str());
    } catch (const std::exception &thrown) {
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0, "Alembic: %.300s", thrown.what());
    }
}

/* ---- writing ---- */

/* A file under another name until it is whole. The library writes from destructors, too, which must
 * not throw. So a failure is remembered, and what follows it goes nowhere. */
class new_file : private std::streambuf {
  public:
    explicit new_file(const char *path)
        : path_(path), name_(path_ + "." + std::to_string(getpid()) + ".tmp"), stream_(this) {
        file_ = fopen(name_.c_str(), "wb");
        if (!file_) fail(errno);
    }
    new_file(const new_file &) = delete;
    new_file &operator=(const new_file &) = delete;
    ~new_file() {
        if (file_) fclose(file_);
        if (!is_committed_) unlink(name_.c_str());
    }
    std::ostream *get_stream() { return &stream_; }
    void commit() {
        note(fflush(file_) == 0 && fsync(fileno(file_)) == 0);
        note(fclose(file_) == 0);
        file_ = nullptr;
        note(failure_ != 0 || rename(name_.c_str(), path_.c_str()) == 0);
        if (failure_ != 0) fail(failure_);
        is_committed_ = true;
    }

  private:
    static void fail(int number) {
        throw std::ios_base::failure("", std::error_code(number, std::generic_category()));
    }
    void note(bool is_fine) {
        if (!is_fine && failure_ == 0) failure_ = errno;
    }
    std::streamsize xsputn(const char *bytes, std::streamsize count) override {
        if (failure_ == 0) note(fwrite(bytes, 1, (size_t)count, file_) == (size_t)count);
        position_ += count;
        return count;
    }
    int_type overflow(int_type value) override {
        char const byte = traits_type::to_char_type(value);
        xsputn(&byte, 1);
        return traits_type::not_eof(value);
    }
    pos_type seekoff(off_type offset, std::ios_base::seekdir from,
                     std::ios_base::openmode) override {
        off_type const begin = from == std::ios_base::cur ? position_ : 0;
        if (from == std::ios_base::end) return pos_type(off_type(-1));
        if (from != std::ios_base::cur || offset != 0) {
            position_ = begin + offset;
            if (failure_ == 0) note(fseeko(file_, position_, SEEK_SET) == 0);
        }
        return position_;
    }
    pos_type seekpos(pos_type place, std::ios_base::openmode which) override {
        return seekoff(off_type(place), std::ios_base::beg, which);
    }

    std::string path_, name_;
    std::ostream stream_;
    FILE *file_ = nullptr;
    off_type position_ = 0;
    int failure_ = 0; /* the first errno */
    bool is_committed_ = false;
};

/* Slashes part the names of Alembic's objects. */
std::string clean_name(const char *name) {
    std::string result(name);
    std::replace(result.begin(), result.end(), '/', '_');
    return result;
}

class mesh_writer {
  public:
    mesh_writer(animation_job *job, size_t surface, const abc::OObject &top, uint32_t sampling)
        : job_(job), surface_(surface), def_(job->def->surfaces[surface]) {
        std::string const name = clean_name(def_.name);
        bool const is_moving = animation_is_moving(job->def, surface);
        abc::OObject parent = top;
        if (def_.motion == TULLE_ANIMATION_RIGID) {
            xform_ = geom::OXform(top, name, is_moving ? sampling : 0);
            parent = xform_;
        }
        mesh_ = geom::OPolyMesh(parent, name + "_mesh",
                                is_moving && def_.motion == TULLE_ANIMATION_DEFORMS ? sampling : 0);
        size_t const corner_count = 3 * def_.mesh.triangle_count;
        for (size_t i = 0; i < corner_count; i++) {
            size_t const corner = 3 * (i / 3) + 2 - i % 3;
            corners_.push_back((int32_t)def_.mesh.triangles[corner]);
            if (def_.corner_uvs)
                uvs_.emplace_back((float)def_.corner_uvs[2 * corner],
                                  (float)def_.corner_uvs[2 * corner + 1]);
        }
        for (abc::V2f &uv : uvs_)
            if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = abc::V2f(0.0f, 0.0f);
        counts_.assign(def_.mesh.triangle_count, 3);
    }

    tulle_status write_frame(uint32_t frame, tulle_error *error) {
        bool const is_rigid = def_.motion == TULLE_ANIMATION_RIGID;
        if (frame > 0 && !animation_is_moving(job_->def, surface_)) return TULLE_OK;
        if (is_rigid) {
            tulle_status const status = write_pose(frame, error);
            if (status != TULLE_OK) return status;
        }
        if (frame > 0 && is_rigid) return TULLE_OK;
        tulle_status const status = animation_read(job_, surface_, frame, error);
        if (status != TULLE_OK) return status;
        animation_compute_normals(job_, surface_);
        size_t const count = def_.mesh.vertex_count;
        abc::P3fArraySample const points((const abc::V3f *)job_->points, count);
        abc::N3fArraySample const normals((const abc::N3f *)job_->normals, count);
        geom::ON3fGeomParam::Sample const normal_sample(normals, geom::kVertexScope);
        if (frame > 0) {
            geom::OPolyMeshSchema::Sample sample(points);
            sample.setNormals(normal_sample);
            mesh_.getSchema().set(sample);
            return TULLE_OK;
        }
        geom::OV2fGeomParam::Sample uv_sample;
        if (!uvs_.empty())
            uv_sample =
                geom::OV2fGeomParam::Sample(abc::V2fArraySample(uvs_), geom::kFacevaryingScope);
        mesh_.getSchema().set(geom::OPolyMeshSchema::Sample(points, abc::Int32ArraySample(corners_),
                                                            abc::Int32ArraySample(counts_),
                                                            uv_sample, normal_sample));
        return TULLE_OK;
    }

  private:
    tulle_status write_pose(uint32_t frame, tulle_error *error) {
        double pose[7];
        tulle_status const status = animation_read_pose(job_, surface_, frame, pose, error);
        if (status != TULLE_OK) return status;
        Imath::Quatd const turn(pose[3], pose[4], pose[5], pose[6]);
        abc::M44d matrix = turn.toMatrix44();
        for (int k = 0; k < 3; k++) matrix[3][k] = pose[k];
        geom::XformSample sample;
        sample.setMatrix(matrix);
        xform_.getSchema().set(sample);
        return TULLE_OK;
    }

    animation_job *job_;
    size_t surface_;
    const tulle_animation_surface &def_;
    geom::OXform xform_;
    geom::OPolyMesh mesh_;
    std::vector<int32_t> corners_, counts_;
    std::vector<abc::V2f> uvs_;
};

tulle_status write_archive(animation_job *job, tulle_error *error) {
    const tulle_animation_def *const def = job->def;
    new_file file(job->path);
    {
        abc::MetaData about;
        about.set(Alembic::Abc::kApplicationNameKey, "tulle");
        Alembic::AbcCoreOgawa::WriteArchive const writer;
        abc::OArchive archive(writer(file.get_stream(), about));
        std::vector<double> const times(def->times, def->times + def->frame_count);
        uint32_t const sampling = archive.addTimeSampling(
            abc::TimeSampling(abc::TimeSamplingType(abc::TimeSamplingType::kAcyclic), times));
        std::vector<std::unique_ptr<mesh_writer>> meshes;
        for (size_t s = 0; s < def->surface_count; s++)
            meshes.emplace_back(new mesh_writer(job, s, archive.getTop(), sampling));
        for (uint32_t frame = 0; frame < def->frame_count; frame++)
            for (std::unique_ptr<mesh_writer> &mesh : meshes) {
                tulle_status const status = mesh->write_frame(frame, error);
                if (status != TULLE_OK) return status;
            }
    }
    file.commit();
    return TULLE_OK;
}

/* ---- reading ---- */

/* A mesh of the file, and the transforms above it from the top down. */
struct found_mesh {
    geom::IPolyMesh mesh;
    std::vector<geom::IXform> xforms;
    size_t vertex_begin, vertex_count;
    size_t triangle_begin, triangle_count;
};

struct alembic_file {
    std::string path;
    abc::IArchive archive;
    std::vector<found_mesh> meshes;
    std::vector<uint32_t> triangles;
    std::vector<double> times;
    bool has_other_objects = false; /* curves, points, subdivided surfaces that are not read */
    memory heap = memory_default();
    polygon_cutter cutter = {};
    ~alembic_file() {
        if (cutter.heap) polygon_cutter_destroy(&cutter);
    }
};

struct alembic_state {
    alembic_file *file;
};

void find_meshes(alembic_file *file, const abc::IObject &object, std::vector<geom::IXform> xforms) {
    const abc::MetaData &about = object.getMetaData();
    if (geom::IXform::matches(about)) {
        geom::IXform const xform(object, abc::kWrapExisting);
        if (!xform.getSchema().getInheritsXforms()) xforms.clear();
        xforms.push_back(xform);
    } else if (geom::IPolyMesh::matches(about)) {
        file->meshes.push_back({geom::IPolyMesh(object, abc::kWrapExisting), xforms, 0, 0, 0, 0});
    } else if (!about.get("schema").empty() && !geom::IFaceSet::matches(about)) {
        file->has_other_objects = true;
    }
    for (size_t i = 0; i < object.getNumChildren(); i++)
        find_meshes(file, object.getChild(i), xforms);
}

void add_times(std::set<double> *times, const abc::TimeSamplingPtr &sampling, size_t count) {
    if (count > frame_limit) throw std::runtime_error("there are too many samples");
    for (size_t i = 0; count > 1 && i < count; i++)
        times->insert(sampling->getSampleTime((abc::index_t)i));
}

/* The polygons, cut within themselves. */
void add_triangles(alembic_file *file, found_mesh *found, size_t vertex_begin) {
    geom::IPolyMeshSchema &schema = found->mesh.getSchema();
    std::string const name = found->mesh.getFullName();
    if (schema.getTopologyVariance() == geom::kHeterogenousTopology)
        throw std::runtime_error("the faces of " + name + " change over time; bake them once");
    geom::IPolyMeshSchema::Sample const sample = schema.getValue();
    const abc::Int32ArraySamplePtr corners = sample.getFaceIndices(),
                                   counts = sample.getFaceCounts();
    const abc::P3fArraySamplePtr points = sample.getPositions();
    found->vertex_begin = vertex_begin;
    found->vertex_count = points ? points->size() : 0;
    found->triangle_begin = file->triangles.size() / 3;
    std::vector<double> positions;
    for (size_t i = 0; i < found->vertex_count; i++)
        for (int k = 0; k < 3; k++) positions.push_back((double)(*points)[i][k]);
    std::vector<uint32_t> triangles;
    std::vector<polygon_fan> fans;
    size_t begin = 0;
    for (size_t face = 0; counts && corners && face < counts->size(); face++) {
        int32_t const corner_count = (*counts)[face];
        if (corner_count < 0 || (size_t)corner_count > corners->size() - begin)
            throw std::runtime_error("the faces of " + name + " need more corners than it has");
        const int32_t *const around = corners->get() + begin;
        for (int32_t k = 0; k < corner_count; k++)
            if (around[k] < 0 || (size_t)around[k] >= found->vertex_count)
                throw std::runtime_error("a face of " + name + " uses a vertex that is not there");
        if (corner_count > 3)
            fans.push_back(
                {triangles.size() / 3, (uint32_t)corner_count - 2, (uint32_t)face, false});
        for (int32_t k = 2; k < corner_count; k++)
            for (int32_t const corner : {0, k - 1, k})
                triangles.push_back((uint32_t)around[corner]);
        begin += (size_t)corner_count;
    }
    polygon_list const list = {positions.data(), triangles.data(), nullptr, fans.data(),
                               fans.size()};
    tulle_error error = {};
    if (polygons_cut(&file->cutter, &list, &error) != TULLE_OK)
        throw std::runtime_error(name + ": " + error.message);
    for (uint32_t const vertex : triangles)
        file->triangles.push_back((uint32_t)vertex_begin + vertex);
    found->triangle_count = file->triangles.size() / 3 - found->triangle_begin;
}

abc::M44d read_matrix(geom::IXform &xform, double time);

/* Turns over triangles that go around clockwise as seen from outside: all but those that a mirror
 * shows, in the first frame in which it does not flatten them. */
void turn_triangles(alembic_file *file, found_mesh *found) {
    double side = 0.0;
    for (size_t i = 0; i < file->times.size() && side == 0.0; i++) {
        abc::M44d matrix;
        for (geom::IXform &xform : found->xforms)
            matrix = read_matrix(xform, file->times[i]) * matrix;
        side = matrix.determinant();
    }
    for (size_t i = 0; i < found->triangle_count && !(side < 0.0); i++) {
        uint32_t *const corners = file->triangles.data() + 3 * (found->triangle_begin + i);
        std::swap(corners[0], corners[2]);
    }
}

void open_archive(alembic_file *file, animation_content *content) {
    Alembic::AbcCoreOgawa::ReadArchive const reader;
    file->archive = abc::IArchive(reader, file->path, abc::ErrorHandler::kThrowPolicy);
    find_meshes(file, file->archive.getTop(), {});
    file->cutter.heap = &file->heap;
    file->cutter.path = file->path.c_str();
    file->cutter.place = "face";
    std::set<double> times;
    size_t vertex_count = 0;
    for (found_mesh &found : file->meshes) {
        add_triangles(file, &found, vertex_count);
        vertex_count += found.vertex_count;
        if (vertex_count > vertex_limit || file->triangles.size() > 3 * vertex_limit)
            throw std::runtime_error("there are too many vertices or triangles");
        const abc::IP3fArrayProperty points = found.mesh.getSchema().getPositionsProperty();
        add_times(&times, points.getTimeSampling(), points.getNumSamples());
        for (geom::IXform &xform : found.xforms)
            add_times(&times, xform.getSchema().getTimeSampling(),
                      xform.getSchema().getNumSamples());
    }
    if (vertex_count == 0) throw std::runtime_error("it holds no polygon mesh");
    file->times.assign(times.begin(), times.end());
    if (file->times.empty()) file->times.push_back(0.0);
    for (found_mesh &found : file->meshes) turn_triangles(file, &found);
    content->info.vertex_count = vertex_count;
    content->info.triangle_count = file->triangles.size() / 3;
    content->info.frame_count = (uint32_t)file->times.size();
    content->info.has_times = 1;
    content->info.is_y_up = 1;
    content->info.meters_per_unit = 1.0;
    content->triangles = file->triangles.data();
    content->times = file->times.data();
    char polygons[200];
    polygon_cutter_describe(&file->cutter, polygons, sizeof polygons);
    bool const has_others = file->has_other_objects;
    (void)snprintf(content->info.note, sizeof content->info.note, "%s%s%s",
                   has_others ? "all but polygon meshes is passed over" : "",
                   has_others && polygons[0] ? "; " : "", polygons);
}

/* The samples around a time, and how far it lies between them. */
struct sample_place {
    abc::index_t first, second;
    double share;
};

sample_place find_samples(const abc::TimeSamplingPtr &sampling, size_t count, double time) {
    std::pair<abc::index_t, double> const low = sampling->getFloorIndex(time, (abc::index_t)count),
                                          high = sampling->getCeilIndex(time, (abc::index_t)count);
    double const length = high.second - low.second;
    bool const is_between = low.first != high.first && length > 0.0 && time > low.second;
    if (!is_between) return {low.first, low.first, 0.0};
    if (!(time < high.second)) return {high.first, high.first, 0.0};
    return {low.first, high.first, (time - low.second) / length};
}

abc::M44d read_matrix(geom::IXform &xform, double time) {
    geom::IXformSchema &schema = xform.getSchema();
    sample_place const place = find_samples(schema.getTimeSampling(), schema.getNumSamples(), time);
    abc::M44d const first = schema.getValue(abc::ISampleSelector(place.first)).getMatrix();
    if (!(place.share > 0.0)) return first;
    abc::M44d const second = schema.getValue(abc::ISampleSelector(place.second)).getMatrix();
    return first * (1.0 - place.share) + second * place.share;
}

void read_mesh(found_mesh &found, double time, double *positions) {
    const abc::IP3fArrayProperty points = found.mesh.getSchema().getPositionsProperty();
    sample_place const place = find_samples(points.getTimeSampling(), points.getNumSamples(), time);
    abc::P3fArraySamplePtr samples[2];
    points.get(samples[0], abc::ISampleSelector(place.first));
    points.get(samples[1], abc::ISampleSelector(place.second));
    for (const abc::P3fArraySamplePtr &sample : samples)
        if (!sample || sample->size() != found.vertex_count)
            throw std::runtime_error("the number of vertices of " + found.mesh.getFullName() +
                                     " changes over time");
    abc::M44d matrix;
    for (geom::IXform &xform : found.xforms) matrix = read_matrix(xform, time) * matrix;
    bool const is_moved = matrix != abc::M44d();
    for (size_t i = 0; i < found.vertex_count; i++) {
        abc::V3d point((*samples[0])[i]);
        if (place.share > 0.0) point += place.share * (abc::V3d((*samples[1])[i]) - point);
        if (is_moved) point = point * matrix;
        for (int k = 0; k < 3; k++) {
            if (!std::isfinite(point[k]))
                throw std::runtime_error("a coordinate of " + found.mesh.getFullName() +
                                         " is not finite");
            positions[3 * i + (size_t)k] = point[k];
        }
    }
}

tulle_status open_alembic(memory *heap, const char *path, void *state, animation_content *content,
                          tulle_error *error) {
    (void)heap; /* the library has a heap of its own */
    if (access(path, R_OK) != 0)
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "cannot be opened: %s",
                            strerror(errno));
    try {
        alembic_file *const file = new alembic_file;
        ((alembic_state *)state)->file = file;
        file->path = path;
        open_archive(file, content);
        return TULLE_OK;
    } catch (...) {
        return tell_exception(path, error);
    }
}

tulle_status read_alembic(void *state, uint32_t frame, double *positions, tulle_error *error) {
    alembic_file *const file = ((alembic_state *)state)->file;
    try {
        for (found_mesh &found : file->meshes)
            read_mesh(found, file->times[frame], positions + 3 * found.vertex_begin);
        return TULLE_OK;
    } catch (...) {
        return tell_exception(file->path.c_str(), error);
    }
}

void close_alembic(void *state) { delete ((alembic_state *)state)->file; }

} // namespace

extern "C" {

tulle_status alembic_write(animation_job *job, tulle_error *error) {
    try {
        return write_archive(job, error);
    } catch (...) {
        return tell_exception(job->path, error);
    }
}

extern const animation_reader alembic_reader;
const animation_reader alembic_reader = {{".abc", NULL}, sizeof(alembic_state), open_alembic,
                                         read_alembic,   close_alembic,         NULL};
}
