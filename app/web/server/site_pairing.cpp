#include <chrono>
#include <cstdint>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/peer_name.h"
#include "app/journal/log.h"
#include "app/journal/log_limit.h"
#include "app/web/answers/answers.h"
#include "app/web/http/cookie.h"
#include "app/web/server/site.h"

/// Browsers that pair and leave.
namespace tribus::web {
namespace {

/// The name of who asks. A proxy on this machine says it.
std::string asker(const std::string& who, const HttpRequest& request) {
    return is_on_this_machine(who) ? peer_name(request.forwarded_for).value_or(who) : who;
}

std::int64_t whole_seconds(Duration duration) {
    return std::chrono::ceil<std::chrono::seconds>(duration).count();
}

HttpAnswer wrong_code(int status, const std::string& error, Duration pause) {
    HttpAnswer answer = json_answer({{"error", error}, {"wait_s", whole_seconds(pause)}}, status);
    answer.headers = fmt::format("Retry-After: {}\r\n", whole_seconds(pause));
    return answer;
}

}  // namespace

Site::Reply Site::pair(const Asked& asked) {
    const HttpRequest& request = asked.request;
    const auto code = text_in(request.body, "code");
    if (!code) {
        return refused(400, "the code is missing");
    }
    const std::string address = asker(asked.who, request);
    if (const Duration left = pairing_pauses_.left(address, asked.now); left > Duration::zero()) {
        return wrong_code(429, "the code before was wrong; wait", left);
    }
    const auto cookie = new_cookie();
    if (!cookie) {
        return refused(500, cookie.error());
    }
    const auto tried = pairing_.try_code(
        *code, wall_now(),
        JoiningBrowser{text_in(request.body, "name").value_or(""), hash_of_cookie(*cookie)});
    if (!tried) {
        return refused(500, tried.error());
    }
    if (!tried->role && !tried->any_valid) {
        return refused(410, "no code is valid now; `sudo tribus pair` prints a new one");
    }
    if (!tried->role) {
        const Duration pause = pairing_pauses_.wrong(address, asked.now);
        if (const auto swallowed = wrong_codes_limit_.pass(asked.now)) {
            log_warning("a wrong code came from {}; its next one counts after {} s{}", address,
                        whole_seconds(pause), swallowed_note(*swallowed));
        }
        return wrong_code(403, "the code is wrong", pause);
    }
    pairing_pauses_.right(address);
    HttpAnswer answer = json_answer({{"role", std::string(word_of(*tried->role))}});
    answer.headers =
        fmt::format("Set-Cookie: {}={}; HttpOnly; SameSite=Strict; Path=/; Max-Age={}\r\n",
                    cookie_name(request.host), *cookie, PairingFolder::kSessionLasts.count());
    return answer;
}

Site::Reply Site::leave(const Asked& asked) {
    const std::string name = cookie_name(asked.request.host);
    if (auto left = pairing_.leave(hash_of_cookie(cookie_value(asked.request.cookie, name)));
        !left) {
        return refused(500, left.error());
    }
    HttpAnswer answer = json_answer(nlohmann::ordered_json::object());
    answer.headers =
        fmt::format("Set-Cookie: {}=; HttpOnly; SameSite=Strict; Path=/; Max-Age=0\r\n", name);
    return answer;
}

}  // namespace tribus::web
