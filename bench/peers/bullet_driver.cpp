// Runs a case of bench-peers in Bullet: bullet_driver CASE OUTPUT. CASE and OUTPUT are as run.py
// says.
//
// `set world soft` is Bullet's older position-based soft body, `set world deformable` its
// mass-spring cloth with self-collision. Both see obstacles as signed distances of convex shapes
// only: what lies in the plane z = 0 becomes a plane, what is a sphere up to a thousandth a sphere,
// any other obstacle the convex hull of its vertices.
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

struct Case {
    std::vector<std::pair<std::string, double>> obstacles; // path, friction with the cloth
    std::map<std::string, std::string> values;

    double number(const std::string &key) const { return std::atof(values.at(key).c_str()); }
};

Case read_case(const char *path) {
    Case read;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string key, name, value;
        words >> key >> name >> value;
        if (key == "obstacle") {
            read.obstacles.emplace_back(name, std::atof(value.c_str()));
        } else if (key == "set") {
            read.values[name] = value;
        } else {
            read.values[key] = name;
        }
    }
    return read;
}

struct Mesh {
    std::vector<btScalar> vertices;
    std::vector<int> triangles;

    size_t count() const { return vertices.size() / 3; }
    btVector3 at(size_t k) const {
        return {vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]};
    }
};

Mesh read_mesh(const std::string &path) {
    Mesh mesh;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string key;
        words >> key;
        for (int k = 0; k < 3 && (key == "v" || key == "f"); k++) {
            double value = 0;
            words >> value;
            if (key == "v") {
                mesh.vertices.push_back(btScalar(value));
            } else {
                mesh.triangles.push_back(int(value) - 1);
            }
        }
    }
    return mesh;
}

btRigidBody *make_obstacle(const Mesh &mesh, btScalar margin) {
    btVector3 low = mesh.at(0), high = mesh.at(0);
    for (size_t k = 0; k < mesh.count(); k++) {
        low.setMin(mesh.at(k));
        high.setMax(mesh.at(k));
    }
    btVector3 centre = (low + high) / 2;
    btScalar radius = 0, least = SIMD_INFINITY;
    for (size_t k = 0; k < mesh.count(); k++) {
        radius = std::max(radius, (mesh.at(k) - centre).length());
        least = std::min(least, (mesh.at(k) - centre).length());
    }
    btCollisionShape *shape = nullptr;
    btTransform place = btTransform::getIdentity();
    if (low.z() == 0 && high.z() == 0) {
        shape = new btStaticPlaneShape(btVector3(0, 0, 1), 0);
        shape->setMargin(margin);
    } else if (least > btScalar(0.999) * radius) {
        shape = new btSphereShape(radius + margin); // a sphere has no margin of its own
        place.setOrigin(centre);
    } else {
        auto *hull = new btConvexHullShape();
        for (size_t k = 0; k < mesh.count(); k++) {
            hull->addPoint(mesh.at(k) - centre, false);
        }
        hull->recalcLocalAabb();
        shape = hull;
        shape->setMargin(margin);
        place.setOrigin(centre);
    }
    auto *body = new btRigidBody(0, new btDefaultMotionState(place), shape, btVector3(0, 0, 0));
    body->setWorldTransform(place);
    return body;
}

// The broad phase and all else that either kind of world stands on; lives to the end of the
// program.
struct Parts {
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver rigid_solver;
    btDeformableBodySolver deformable_solver;
    btDeformableMultiBodyConstraintSolver deformable_rigid_solver;
};

struct Simulation {
    btDiscreteDynamicsWorld *world = nullptr;
    btSoftBody *cloth = nullptr;
};

btSoftBody *make_cloth(btSoftBodyWorldInfo &info, const Case &read) {
    Mesh mesh = read_mesh(read.values.at("cloth"));
    btSoftBody *cloth = btSoftBodyHelpers::CreateFromTriMesh(
        info, mesh.vertices.data(), mesh.triangles.data(), int(mesh.triangles.size() / 3), false);
    cloth->getCollisionShape()->setMargin(btScalar(read.number("margin")));
    cloth->setTotalMass(btScalar(read.number("mass")));
    cloth->m_cfg.kDF = 1; // the obstacle's friction is that of the pair
    return cloth;
}

void set_info(btSoftBodyWorldInfo &info, Parts &parts, const btVector3 &gravity) {
    info.m_broadphase = &parts.broadphase;
    info.m_dispatcher = &parts.dispatcher;
    info.m_gravity = gravity;
    info.air_density = 0;
    info.m_sparsesdf.Initialize();
}

Simulation make_soft(Parts &parts, const Case &read, const btVector3 &gravity) {
    auto *world = new btSoftRigidDynamicsWorld(&parts.dispatcher, &parts.broadphase,
                                               &parts.rigid_solver, &parts.configuration);
    set_info(world->getWorldInfo(), parts, gravity);
    btSoftBody *cloth = make_cloth(world->getWorldInfo(), read);
    cloth->m_cfg.piterations = int(read.number("iterations"));
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    world->addSoftBody(cloth);
    return {world, cloth};
}

Simulation make_deformable(Parts &parts, const Case &read, const btVector3 &gravity) {
    parts.deformable_rigid_solver.setDeformableSolver(&parts.deformable_solver);
    auto *world = new btDeformableMultiBodyDynamicsWorld(
        &parts.dispatcher, &parts.broadphase, &parts.deformable_rigid_solver, &parts.configuration,
        &parts.deformable_solver);
    set_info(world->getWorldInfo(), parts, gravity);
    btSoftBody *cloth = make_cloth(world->getWorldInfo(), read);
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN |
                              btSoftBody::fCollision::VF_DD;
    cloth->m_cfg.kKHR = 1;
    cloth->m_cfg.kCHR = 1;
    cloth->setSelfCollision(true);
    world->addSoftBody(cloth);
    world->addForce(cloth,
                    new btDeformableMassSpringForce(btScalar(read.number("spring")),
                                                    btScalar(read.number("damping")), false));
    world->addForce(cloth, new btDeformableGravityForce(gravity));
    world->setImplicit(true);
    world->setLineSearch(false);
    world->setUseProjection(true);
    return {world, cloth};
}

double get_cpu() {
    rusage usage = {};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

void write_frame(const btSoftBody *cloth, FILE *raw, FILE *told, double time, double cpu) {
    for (int k = 0; k < cloth->m_nodes.size(); k++) {
        const btVector3 &x = cloth->m_nodes[k].m_x;
        const float point[3] = {float(x.x()), float(x.y()), float(x.z())};
        fwrite(point, sizeof(float), 3, raw);
    }
    fflush(raw);
    fprintf(told, "frame %.9f %.3f\n", time, cpu);
    fflush(told);
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: bullet_driver CASE OUTPUT\n");
        return 2;
    }
    const Case read = read_case(argv[1]);
    const std::string output = argv[2];
    const btVector3 gravity(0, 0, btScalar(-read.number("gravity")));
    auto *parts = new Parts;
    const bool is_soft = read.values.at("world") == "soft";
    Simulation made =
        is_soft ? make_soft(*parts, read, gravity) : make_deformable(*parts, read, gravity);
    made.world->setGravity(gravity);
    for (const auto &[path, friction] : read.obstacles) {
        btRigidBody *body = make_obstacle(read_mesh(path), btScalar(read.number("margin")));
        body->setFriction(btScalar(friction));
        made.world->addRigidBody(body);
    }

    FILE *raw = fopen((output + "/frames.raw").c_str(), "wb");
    FILE *told = fopen((output + "/told.txt").c_str(), "w");
    if (!raw || !told) {
        return 2;
    }
    fprintf(told, "version %d.%02d%s\n", btGetVersion() / 100, btGetVersion() % 100,
            sizeof(btScalar) == sizeof(double) ? " (double)" : " (float)");
    write_frame(made.cloth, raw, told, 0, 0);
    const double start = get_cpu();
    const double interval = read.number("interval");
    const int steps = int(read.number("steps"));
    const int count = steps * int(read.number("frames"));
    const btScalar length = btScalar(interval / steps);
    for (int step = 1; step <= count; step++) {
        made.world->stepSimulation(length, 1, length);
        const double cpu = get_cpu() - start;
        const bool is_over = cpu > read.number("limit");
        if (step % steps == 0 || is_over) {
            write_frame(made.cloth, raw, told, step * interval / steps, cpu);
        }
        if (is_over && step < count) {
            fprintf(told, "message stopped at the limit of processor time\n");
            break;
        }
    }
    fclose(raw);
    fclose(told);
    return 0;
}
