#pragma once

#include <string>

/// A joystick as the library SDL 2 reads it, which most games use.
namespace tribus::test {

class SdlJoystick {
  public:
    /// Opens the input device, the only one that SDL is shown.
    explicit SdlJoystick(const std::string& device);
    SdlJoystick(const SdlJoystick&) = delete;
    SdlJoystick& operator=(const SdlJoystick&) = delete;
    ~SdlJoystick();

    bool valid() const { return joystick_ != nullptr; }
    const std::string& error() const { return error_; }
    std::string name() const;
    int axes() const;
    int buttons() const;
    void update();
    int axis(int number) const;
    bool button(int number) const;

  private:
    /// A function of the library.
    template <class Function>
    Function* function(const char* name) const;

    void* library_ = nullptr;
    void* joystick_ = nullptr;
    std::string error_;
};

}  // namespace tribus::test
