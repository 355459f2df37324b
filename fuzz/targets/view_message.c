/* fuzz/targets/view_message.c - what a page says to `tulle view`, and lines of a session: a message
 * that is refused says why; one that is read has its numbers in their ranges; a command that is
 * written is read again to the same bytes. */
#include "app/view/message.h"
#include "app/view/session_file.h"
#include "support/fuzz.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool is_command(request_type type) {
    return type == REQUEST_GRAB || type == REQUEST_DRAG || type == REQUEST_LET_GO ||
           type == REQUEST_CUT_PIN || type == REQUEST_MOVE || type == REQUEST_SET;
}

static void check_numbers(const view_request *request) {
    for (int k = 0; k < 3; k++) {
        FUZZ_CHECK(fabs(request->point[k]) <= 1e6 && fabs(request->position[k]) <= 1e6);
        FUZZ_CHECK(fabs(request->weights[k]) <= 1.001);
    }
    FUZZ_CHECK(request->object <= 65535 && request->value_count <= REQUEST_VALUES_MAX);
    FUZZ_CHECK(isfinite(request->force) && isfinite(request->rate) && isfinite(request->speed));
    FUZZ_CHECK(memchr(request->name, 0, sizeof request->name));
}

static void check_again(view_request first) {
    char reason[REASON_SIZE];
    view_request second;
    view_buffer buffer = {0};
    first.has_id = false;
    first.id = 0;
    buffer_print(&buffer, "{\"at\":12,");
    request_write(&first, &buffer);
    buffer_print(&buffer, "}");
    FUZZ_CHECK(!buffer.is_failed);
    FUZZ_CHECK(request_read((const char *)buffer_get(&buffer), buffer.count, &second, reason) ==
               REQUEST_READ);
    FUZZ_CHECK(memcmp(&first, &second, sizeof first) == 0);
    buffer_put_u8(&buffer, 0);
    session_line line;
    FUZZ_CHECK(session_file_read_line((const char *)buffer_get(&buffer), &line, NULL));
    FUZZ_CHECK(line.at == 12 && !line.is_end && line.request.type == first.type);
    buffer_release(&buffer);
}

static void check_lines(const uint8_t *data, size_t size) {
    char *const text = malloc(size + 1);
    FUZZ_CHECK(text);
    memcpy(text, data, size);
    text[size] = '\0';
    const char *rest = text;
    session_line line;
    tulle_error error = {0};
    while (rest && *rest) {
        const char *const next = session_file_read_line(rest, &line, &error);
        FUZZ_CHECK(!next || next > rest);
        FUZZ_CHECK(next || error.message[0]);
        rest = next;
    }
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char reason[REASON_SIZE];
    view_request request;
    request_outcome const outcome = request_read((const char *)data, size, &request, reason);
    FUZZ_CHECK((outcome == REQUEST_READ) == (reason[0] == '\0'));
    FUZZ_CHECK(strlen(reason) < REASON_SIZE);
    if (outcome == REQUEST_READ) {
        check_numbers(&request);
        if (is_command(request.type)) check_again(request);
        request_release(&request);
    }
    FUZZ_CHECK(!request.text);
    check_lines(data, size);
    return 0;
}

void fuzz_make_seeds(void) {
    static const char *const texts[][2] = {
        {"grab", "{\"type\":\"grab\",\"id\":7,\"object\":3,\"triangle\":5,\"weights\":[0.2,0.3,0.5]"
                 ",\"point\":[1,-1e6,0.1],\"force\":0.3}"},
        {"drag", "{\"type\":\"drag\",\"grab\":9,\"point\":[0.1,0.2,0.30000000000000004]}"},
        {"move", "{\"type\":\"move\",\"object\":1,\"position\":[1,2,3],\"rotation\":[0.6,0,0.8,0],"
                 "\"force\":4}"},
        {"gravity", "{\"type\":\"set\",\"what\":\"gravity\",\"value\":[0,0,-9.81]}"},
        {"material", "{\"type\":\"set\",\"what\":\"material\",\"object\":2,\"value\":\"silk\"}"},
        {"frames", "{\"type\":\"frames\",\"from\":3,\"count\":100,\"step\":2,\"exact\":true}"},
        {"series", "{\"type\":\"series\",\"names\":[\"contacts\",\"seconds\"],\"from\":1,\"to\":9,"
                   "\"buckets\":4}"},
        {"overlays", "{\"type\":\"overlays\",\"names\":[\"contacts\",\"gaps\"]}"},
        {"pick", "{\"type\":\"pick\",\"frame\":1,\"object\":0,\"triangle\":2,\"weights\":[1,0,0]}"},
        {"check", "{\"type\":\"check\",\"text\":\"time: {step: 1/90 s}\\n\"}"},
        {"session", "{\"at\":5,\"type\":\"let_go\",\"grab\":2}\n{\"at\":9,\"type\":\"end\","
                    "\"hash\":\"00000000000000ff\"}\n"}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        fuzz_put_text_seed(texts[i][0], texts[i][1]);
}
