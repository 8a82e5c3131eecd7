# Links of the pages, as the package has them (deploy/CMakeLists.txt). sed -E.

# What is installed elsewhere.
s#\]\(((\.\./)*)config/examples#](\1examples#g
s#\]\(((\.\./)*)deploy/(ansible|networkd|prometheus)#](\1examples/\3#g
s#\]\(((\.\./)*)deploy/can/#](\1../../tribus/can/#g
s#\]\(((\.\./)*)tests/sim/(known_receivers|redundancy)\.txt#](\1docs/\3.txt#g
s#\]\(((\.\./)*)LICENSE\)#](\1copyright)#g

# Versions of the changelog, at the host of the sources.
/^\[[^]]*\]: \.\.\/\.\.\//d

# What only the sources have: of the link its text.
s#\[([^][]*)\]\((\.\./)*(CONTRIBUTING\.md|\.ci|app|config|core|deploy|pipelines|tests|transports)([/#][^)]*)?\)#\1#g
