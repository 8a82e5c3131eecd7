#include "app/client/draft.h"

#include <fcntl.h>

#include <filesystem>

#include "app/cli/new_file.h"
#include "app/cli/replace_file.h"
#include "app/client/control_socket.h"
#include "transports/links/unique_fd.h"

namespace tribus {

bool write_draft(const std::string& socket, std::string_view text) {
    constexpr mode_t kReadByItsDaemon = 0644;
    const std::filesystem::path file(draft_file(socket));
    const UniqueFd folder(
        ::open(file.parent_path().c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!folder.valid()) {
        return false;
    }
    const UniqueFd out = new_file(folder.get(), file.filename().string(), kReadByItsDaemon);
    return out.valid() && write_all(out.get(), text);
}

}  // namespace tribus
