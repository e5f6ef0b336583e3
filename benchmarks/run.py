"""All benchmarks; `benchmarks/README.md` keeps what they printed on a named machine."""

from benchmarks import fem, rigid, stress

if __name__ == "__main__":
    rigid.main()
    fem.main()
    stress.main()
