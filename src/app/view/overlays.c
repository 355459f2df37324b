/* app/view/overlays.c - see overlays.h. */
#include "app/view/overlays.h"

#include "app/view/document.h"

#include <math.h>
#include <string.h>

static const char *const overlay_names[OVERLAY_COUNT] = {"contacts", "velocities", "patches",
                                                         "strain",   "gaps",       "crossings"};

view_overlay_kind overlays_find(const char *name) {
    int kind = 0;
    while (kind < OVERLAY_COUNT && strcmp(overlay_names[kind], name) != 0) kind++;
    return (view_overlay_kind)kind;
}

unsigned overlays_get_possible(const view_document *document) {
    unsigned set = 1u << OVERLAY_CROSSINGS;
    if (document->cloth_count > 0) set |= 1u << OVERLAY_GAPS;
    if (document->is_live || document->has_debug)
        set |= 1u << OVERLAY_CONTACTS | 1u << OVERLAY_VELOCITIES | 1u << OVERLAY_PATCHES;
    if (document->cloth_count > 0 && document->kind != KIND_MESH) set |= 1u << OVERLAY_STRAIN;
    return set;
}

void overlays_write_names(const view_document *document, view_buffer *buffer) {
    unsigned const set = overlays_get_possible(document);
    const char *separator = "";
    buffer_print(buffer, ",\"overlays\":[");
    for (int kind = 0; kind < OVERLAY_COUNT; kind++) {
        if (!(set >> kind & 1u)) continue;
        buffer_print(buffer, "%s\"%s\"", separator, overlay_names[kind]);
        separator = ",";
    }
    buffer_print(buffer, "]");
}

void overlay_begin(view_overlay *overlay) {
    buffer_clear(&overlay->bytes);
    overlay->is_filled = true;
    overlay->count = 0;
}

void overlay_put_doubles(view_overlay *overlay, const double *values, size_t count) {
    for (size_t i = 0; i < count; i++) buffer_put_f32(&overlay->bytes, (float)values[i]);
}

void overlay_put_contacts(view_overlay *overlay, const tulle_contact *contacts, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const tulle_contact *const contact = &contacts[i];
        overlay_put_doubles(overlay, contact->position, 3);
        overlay_put_doubles(overlay, contact->normal, 3);
        overlay_put_doubles(overlay, contact->impulse, 3);
        overlay_put_doubles(overlay, &contact->gap, 1);
        uint32_t flags = contact->object_a == contact->object_b ? 4 : 0;
        if (contact->state == TULLE_CONTACT_STICK) flags |= 1;
        if (contact->state == TULLE_CONTACT_SLIP) flags |= 2;
        buffer_put_u32(&overlay->bytes, flags);
    }
    overlay->count += (uint32_t)count;
}

void overlay_put_object(view_overlay *overlay, size_t object, size_t count) {
    buffer_put_u16(&overlay->bytes, (unsigned)object);
    buffer_put_u16(&overlay->bytes, 0);
    buffer_put_u32(&overlay->bytes, (uint32_t)count);
    overlay->count++;
}

void overlay_put_pairs(view_overlay *overlay, const tulle_check_pair *pairs, size_t count) {
    for (size_t i = 0; i < count; i++) {
        buffer_put_u16(&overlay->bytes, pairs[i].body_a);
        buffer_put_u16(&overlay->bytes, pairs[i].body_b);
        buffer_put_u32(&overlay->bytes, pairs[i].triangle_a);
        buffer_put_u32(&overlay->bytes, pairs[i].triangle_b);
    }
    overlay->count += (uint32_t)count;
}

/* The map from the flat triangle to where it is now takes u to Fu and v to Fv; the strains are
 * |Fu| - 1, |Fv| - 1 and Fu . Fv. All zero where the flat triangle has no area. */
void overlay_measure_flat_strain(const float *uv, const float *positions, const uint32_t corners[3],
                                 double strain[3]) {
    double flat[2][2], edges[2][3];
    for (int e = 0; e < 2; e++) {
        size_t const a = corners[0], b = corners[e + 1];
        for (size_t k = 0; k < 2; k++) flat[e][k] = (double)uv[2 * b + k] - (double)uv[2 * a + k];
        for (size_t k = 0; k < 3; k++)
            edges[e][k] = (double)positions[3 * b + k] - (double)positions[3 * a + k];
    }
    double const area = flat[0][0] * flat[1][1] - flat[0][1] * flat[1][0];
    double u[3], v[3], uu = 0.0, vv = 0.0, uv_product = 0.0;
    memset(strain, 0, 3 * sizeof *strain);
    if (!(fabs(area) > 0.0)) return;
    for (int k = 0; k < 3; k++) {
        u[k] = (flat[1][1] * edges[0][k] - flat[0][1] * edges[1][k]) / area;
        v[k] = (flat[0][0] * edges[1][k] - flat[1][0] * edges[0][k]) / area;
        uu += u[k] * u[k];
        vv += v[k] * v[k];
        uv_product += u[k] * v[k];
    }
    strain[0] = sqrt(uu) - 1.0;
    strain[1] = sqrt(vv) - 1.0;
    strain[2] = uv_product;
}

void overlay_put_flat_strains(view_overlay *overlay, const view_document *document,
                              const float *positions) {
    for (size_t i = 0; i < document->cloth_count; i++) {
        const view_object *const cloth = &document->objects[i];
        if (!cloth->uv) continue;
        overlay_put_object(overlay, i, cloth->mesh.triangle_count);
        for (size_t t = 0; t < cloth->mesh.triangle_count; t++) {
            double strain[3];
            overlay_measure_flat_strain(cloth->uv, positions + 3 * cloth->vertex_begin,
                                        cloth->mesh.triangles + 3 * t, strain);
            overlay_put_doubles(overlay, strain, 3);
        }
    }
}

void overlay_write(const view_overlay *overlay, view_overlay_kind kind, uint32_t frame, double time,
                   view_buffer *buffer) {
    document_write_head((view_head){.kind = 3,
                                    .object = (unsigned)kind + 1,
                                    .frame = frame,
                                    .time = time,
                                    .count = overlay->count},
                        buffer);
    if (overlay->bytes.is_failed) buffer->is_failed = true;
    buffer_put_bytes(buffer, buffer_get(&overlay->bytes), overlay->bytes.count);
}
