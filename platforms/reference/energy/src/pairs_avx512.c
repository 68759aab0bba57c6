typedef int NothingHere; /* a file must declare something */
