#pragma once

#include <string_view>
#include <utility>

namespace tribus {

/// The content of a file, read piece by piece, so that its length does not matter. Thread-bound.
class Pieces {
  public:
    Pieces() = default;
    Pieces(const Pieces&) = delete;
    Pieces& operator=(const Pieces&) = delete;
    virtual ~Pieces() = default;

    /// The next bytes, none at the end. Valid until the next call.
    virtual std::string_view next() = 0;
    /// `next` begins at the start again.
    virtual void rewind() = 0;
};

/// A content in memory, as one piece. It must outlive the object.
class OnePiece final : public Pieces {
  public:
    explicit OnePiece(std::string_view content) : content_(content), rest_(content) {}
    std::string_view next() override { return std::exchange(rest_, {}); }
    void rewind() override { rest_ = content_; }

  private:
    std::string_view content_;
    std::string_view rest_;
};

}  // namespace tribus
