#include "app/client/socket_client.h"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace tribus {

SocketClient::SocketClient(UniqueFd descriptor, std::size_t most_received, Instant now,
                           std::string who)
    : descriptor_(std::move(descriptor)),
      most_received_(most_received),
      quiet_since_(now),
      asking_since_(now),
      who_(std::move(who)) {}

bool SocketClient::receive(Instant now) {
    constexpr std::size_t kBytesAtOnce = 1024;
    std::array<char, kBytesAtOnce> bytes;
    const std::size_t room = std::min(most_received_ - received_.size(), bytes.size());
    if (ended_ || room == 0) {
        return true;
    }
    const ssize_t count = ::recv(descriptor_.get(), bytes.data(), room, MSG_DONTWAIT);
    if (count < 0) {
        return errno == EAGAIN || errno == EINTR;
    }
    ended_ = count == 0;
    if (count > 0) {
        asking_since_ = received_.empty() ? now : asking_since_;
        passed(now);
        received_.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return true;
}

bool SocketClient::discard(Instant now) {
    constexpr Duration kDiscardTime = std::chrono::seconds(2);
    constexpr int kMostPieces = 4;
    constexpr std::size_t kPieceBytes = std::size_t{16} * 1024;
    if (discard_end_ == kNever) {
        discard_end_ = later(now, kDiscardTime);
        ::shutdown(descriptor_.get(), SHUT_WR);
    }
    std::array<char, kPieceBytes> piece;
    for (int i = 0; i < kMostPieces; ++i) {
        const ssize_t count = ::recv(descriptor_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
        if (count <= 0) {
            return count < 0 && (errno == EAGAIN || errno == EINTR) && now < discard_end_;
        }
    }
    return now < discard_end_;
}

std::optional<std::string> SocketClient::take_line() {
    const std::size_t end = received_.find('\n');
    if (end == std::string::npos) {
        return std::nullopt;
    }
    std::string line = received_.substr(0, end);
    received_.erase(0, end + 1);
    if (line.ends_with('\r')) {
        line.pop_back();
    }
    return line;
}

std::optional<std::string> SocketClient::take_answer() {
    auto answer = answer_();
    if (answer) {
        answer_ = nullptr;
    }
    return answer;
}

bool SocketClient::send(std::string text, Instant now) {
    under_way_ = std::move(text);
    sent_ = 0;
    return flush(now);
}

bool SocketClient::flush(Instant now) {
    // One piece at a time: a fast reader of a long answer must not keep the others waiting.
    if (sent_ == under_way_.size() && source_) {
        auto piece = source_();
        if (!piece) {
            return false;
        }
        if (piece->empty()) {
            source_ = nullptr;
        }
        under_way_ = *std::move(piece);
        sent_ = 0;
    }
    while (sent_ < under_way_.size()) {
        const ssize_t count = ::send(descriptor_.get(), under_way_.data() + sent_,
                                     under_way_.size() - sent_, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (count < 0) {
            return errno == EAGAIN || errno == EINTR;
        }
        passed(now);
        sent_ += static_cast<std::size_t>(count);
    }
    return true;
}

bool SocketClient::has_read_all() const {
    int unread = 0;
    return ready() && (::ioctl(descriptor_.get(), SIOCOUTQ, &unread) != 0 || unread == 0);
}

void SocketClient::step(Instant now) {
    next_ += period_;
    if (next_ <= now) {
        next_ += (now - next_) / period_ * period_ + period_;
    }
}

}  // namespace tribus
