#include <array>
#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "app/web/answers/answers.h"
#include "app/web/answers/checks.h"
#include "tests/fuzz/fuzz.h"

namespace tribus::fuzz::web_content_target {
namespace {

constexpr std::array kNames{"toml", "code", "name", "trial", "seconds"};
/// A longer draft is the matter of the target `configuration`.
constexpr std::size_t kLongestDraft = 512;

bool is_object(const std::string& text) {
    return nlohmann::json::parse(text, nullptr, false).is_object();
}

void look_at_members(const std::string& body) {
    for (const char* name : kNames) {
        const auto text = web::text_in(body, name);
        const auto number = web::number_in(body, name);
        require(!text || !number, "a member has one type");
        if (text) {
            require(text->size() <= body.size(), "a text is not longer than what was sent");
            const std::string again = nlohmann::json{{name, *text}}.dump();
            require(web::text_in(again, name) == text, "a text can be sent again");
        }
        if (number) {
            const std::string again = nlohmann::json{{name, *number}}.dump();
            require(web::number_in(again, name) == number, "a number can be sent again");
        }
    }
}

void answer_with(const std::string& body) {
    const web::HttpAnswer forwarded = web::as_it_is(body);
    require(is_object(forwarded.content), "an answer is an object");
    require(forwarded.status == 200 ? forwarded.content == body : forwarded.status == 502,
            "what a daemon says is passed on as it is, or is its error");
    require(is_object(web::refused(400, body).content), "a refusal of any text is an object");
    const auto draft = web::text_in(body, "toml");
    if (draft && draft->size() <= kLongestDraft) {
        require(is_object(web::json_answer(web::check_draft(*draft, "/none/boat.toml")).content),
                "the mistakes of a draft are an object");
    }
}

}  // namespace

/// The content that a page posts, or that a daemon answers.
FUZZ_TARGET(web_content) {
    const std::string body(reinterpret_cast<const char*>(data), size);
    look_at_members(body);
    answer_with(body);
    return 0;
}

}  // namespace tribus::fuzz::web_content_target
