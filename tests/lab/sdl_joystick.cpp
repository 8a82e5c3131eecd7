#include "tests/lab/sdl_joystick.h"

#include <dlfcn.h>

#include <cstdint>
#include <cstdlib>

namespace tribus::test {
namespace {

// From SDL_joystick.h and SDL.h of SDL 2, whose binary interface is stable. Its development package
// would bring a hundred others.
constexpr std::uint32_t kInitJoystick = 0x200;

}  // namespace

template <class Function>
Function* SdlJoystick::function(const char* name) const {
    return reinterpret_cast<Function*>(::dlsym(library_, name));
}

SdlJoystick::SdlJoystick(const std::string& device)
    : library_(::dlopen("libSDL2-2.0.so.0", RTLD_NOW)) {
    if (library_ == nullptr) {
        error_ = ::dlerror();
        return;
    }
    ::setenv("SDL_JOYSTICK_DEVICE", device.c_str(), 1);
    if (function<int(std::uint32_t)>("SDL_Init")(kInitJoystick) == 0) {
        joystick_ = function<void*(int)>("SDL_JoystickOpen")(0);
    }
    if (joystick_ == nullptr) {
        error_ = function<const char*()>("SDL_GetError")();
    }
}

SdlJoystick::~SdlJoystick() {
    if (joystick_ != nullptr) {
        function<void(void*)>("SDL_JoystickClose")(joystick_);
    }
    if (library_ != nullptr) {
        function<void()>("SDL_Quit")();
    }
}

std::string SdlJoystick::name() const {
    return function<const char*(void*)>("SDL_JoystickName")(joystick_);
}
int SdlJoystick::axes() const {
    return function<int(void*)>("SDL_JoystickNumAxes")(joystick_);
}
int SdlJoystick::buttons() const {
    return function<int(void*)>("SDL_JoystickNumButtons")(joystick_);
}
void SdlJoystick::update() {
    function<void()>("SDL_JoystickUpdate")();
}
int SdlJoystick::axis(int number) const {
    return function<std::int16_t(void*, int)>("SDL_JoystickGetAxis")(joystick_, number);
}
bool SdlJoystick::button(int number) const {
    return function<std::uint8_t(void*, int)>("SDL_JoystickGetButton")(joystick_, number) != 0;
}

}  // namespace tribus::test
