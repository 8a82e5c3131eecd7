# README.md as the package has it: the program is there, its sources and their scripts are not. sed -E.
/^## Try it$/,/^## /{
    /^## Try it$/{
        a\
\
With nothing attached:\
\
```sh\
tribus demo           # shows receiver, program and servos at work; Ctrl-C ends it\
```\

        b
    }
    /^## /!d
}

# The package is made and installed.
/^deploy\/package\.sh/d
/^sudo apt install \.\/tribus/d
